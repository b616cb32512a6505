#pragma once

// The subcommands of the furrow tool. Each adds itself to the command line and runs when it was chosen;
// faults are thrown as pipeline::Error.

#include <CLI/CLI.hpp>
#include <functional>
#include <vector>

namespace furrow::cli {

using Command = std::function<void()>;

// Adds the subcommand to `app`; what it returns runs the command with the parsed options.
Command addCook(CLI::App& app);
Command addInfo(CLI::App& app);
Command addCheck(CLI::App& app);
Command addEval(CLI::App& app);
Command addRender(CLI::App& app);
Command addBind(CLI::App& app);
Command addExport(CLI::App& app);

}  // namespace furrow::cli
