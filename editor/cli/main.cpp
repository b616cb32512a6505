// furrow: cook, inspect and preview wrinkle assets from the command line.

#include <csignal>
#include <cstdio>
#include <exception>
#include <map>
#include <string>

#include "editor/cli/commands.h"
#include "pipeline/error.h"
#include "pipeline/heap.h"
#include "pipeline/one_line.h"

int main(int argc, char** argv) {
  using furrow::pipeline::Exit;
  std::signal(SIGXFSZ, SIG_IGN);  // a file too long for the user's limit is a fault of writing like any other
  furrow::pipeline::keepFreedMemory();
  CLI::App app("furrow: wrinkles computed on every frame from how the surface is squeezed", "furrow");
  app.set_version_flag("--version", "furrow " FURROW_VERSION);
  app.require_subcommand(1);
  app.footer(
      "Exit status: 0 done, 1 bad data (an input missing, too), 2 bad usage, 3 environment (GL or a forced "
      "backend not available, disk).");
  const std::map<std::string, furrow::cli::Command> commands = {
      {"cook", furrow::cli::addCook(app)},     {"info", furrow::cli::addInfo(app)},
      {"check", furrow::cli::addCheck(app)},   {"eval", furrow::cli::addEval(app)},
      {"render", furrow::cli::addRender(app)}, {"bind", furrow::cli::addBind(app)},
      {"export", furrow::cli::addExport(app)}};
  if (argc > 1 && argv[1][0] != '-' && !commands.contains(argv[1])) {
    std::fprintf(stderr, "furrow: %s: there is no such command: see 'furrow --help'\n", argv[1]);
    return static_cast<int>(Exit::kBadUsage);
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::ExtrasError&) {
    std::fprintf(stderr, "furrow: %s: is not expected here: see 'furrow --help' or 'furrow COMMAND --help'\n",
                 app.remaining(true).front().c_str());
    return static_cast<int>(Exit::kBadUsage);
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "furrow: %s: see 'furrow --help' or 'furrow COMMAND --help'\n", error.what());
    return static_cast<int>(Exit::kBadUsage);
  }
  try {
    commands.at(app.get_subcommands().front()->get_name())();
    return static_cast<int>(Exit::kDone);
  } catch (const furrow::pipeline::Error& error) {
    std::fprintf(stderr, "furrow: %s\n", furrow::pipeline::oneLine(error.what()).c_str());
    return static_cast<int>(error.exit());
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "furrow: out of memory: close other programs or cook a smaller file\n");
    return static_cast<int>(Exit::kEnvironment);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "furrow: unexpected fault (%s): please report it\n", error.what());
    return static_cast<int>(Exit::kBadData);
  }
}
