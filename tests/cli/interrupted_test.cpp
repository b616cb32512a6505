// Whatever ends a cook, the old asset is whole, and no temporary stays.

#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>

#include <chrono>
#include <set>

#include "tests/cli/sheet.h"
#include "tests/cli/tool.h"

namespace furrow::test {
namespace {

class Interrupted : public ToolTest {
 protected:
  std::vector<std::string> cookInto(const std::filesystem::path& out,
                                    const std::filesystem::path& recipe) const {
    return {"cook", source, "--recipe", recipe, "-o", out, "--geometry", "raw", "--quiet"};
  }

  std::set<std::string> namesIn(const std::filesystem::path& where) const {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(where))
      names.insert(entry.path().filename());
    return names;
  }

  // A cook that has no room for the new asset says so and keeps the old one.
  void expectNoRoom(const std::filesystem::path& where, const std::string& reason, const Outcome& outcome,
                    const std::string& old) const {
    expectOneLine(outcome, 3, (where / "a.furrow").string() + ": cannot be written (" + reason + ")");
    EXPECT_TRUE(readText(where / "a.furrow") == old);
    EXPECT_EQ(namesIn(where), std::set<std::string>{"a.furrow"});
  }

  const std::filesystem::path source = write("sheet.obj", foldedSheet());
  const std::filesystem::path small =
      write("small.json", R"({"layers": [{"name": "a", "compress": "none"}]})");
  const std::filesystem::path large =
      write("large.json", R"({"mapSize": 512, "layers": [{"name": "a", "direction": {"axis": [1, 0, 0]}}]})");
};

TEST_F(Interrupted, ByKillAtAnyMoment) {
  const std::filesystem::path asset = output() / "a.furrow";
  ASSERT_EQ(run(cookInto(asset, large)).status, 0);
  const std::string new_bytes = readText(asset);
  ASSERT_EQ(run(cookInto(asset, small)).status, 0);
  const std::string old_bytes = readText(asset);
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_EQ(run(cookInto(asset, large)).status, 0);
  auto longest =
      2 * (std::chrono::steady_clock::now() - begin);  // before a kill; the machine may be busier now
  ASSERT_EQ(run(cookInto(asset, small)).status, 0);

  constexpr int kKills = 40;
  size_t killed = 0;
  for (int i = 0; i < kKills; ++i) {
    const auto delay = longest * i / kKills;
    const pid_t cook = start(cookInto(asset, large));
    ASSERT_GT(cook, 0);
    std::this_thread::sleep_for(delay);
    ::kill(cook, SIGKILL);
    int status = 0;
    ASSERT_EQ(::waitpid(cook, &status, 0), cook);
    if (WIFSIGNALED(status))
      ++killed;
    else
      longest = delay;  // or less busy
    const std::string bytes = readText(asset);
    ASSERT_TRUE(bytes == old_bytes || bytes == new_bytes);
    ASSERT_LE(namesIn(output()).size(), 2u) << "the next cook removes what a kill leaves";
    if (bytes == new_bytes) {
      ASSERT_EQ(run(cookInto(asset, small)).status, 0);
    }
  }
  EXPECT_GT(killed, 5u) << "the kills came too late to say anything";
  ASSERT_EQ(run(cookInto(asset, large)).status, 0);
  EXPECT_EQ(namesIn(output()), std::set<std::string>{"a.furrow"});
}

TEST_F(Interrupted, ByAFullDisk) {
  const std::filesystem::path disk = folder() / "disk";
  std::filesystem::create_directory(disk);
  if (::mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=128k") != 0)
    GTEST_SKIP() << "a small file system cannot be mounted here: " << std::strerror(errno);
  struct Unmount {
    const std::filesystem::path& folder;
    ~Unmount() { ::umount(folder.c_str()); }
  } const unmount{disk};
  ASSERT_EQ(run(cookInto(disk / "a.furrow", small)).status, 0);
  const std::string old = readText(disk / "a.furrow");
  expectNoRoom(disk, "No space left on device", run(cookInto(disk / "a.furrow", large)), old);

  // A cache without room costs no asset.
  std::vector<std::string> cached = cookInto(output() / "b.furrow", large);
  cached.pop_back();
  cached.insert(cached.end(), {"--cache", disk / "cache"});
  const Outcome outcome = run(cached);
  EXPECT_EQ(outcome.status, 0);
  EXPECT_NE(outcome.err.find("warning: not kept in the cache: "), std::string::npos) << outcome.err;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(disk / "cache"))
    EXPECT_TRUE(entry.is_directory()) << entry.path();
}

TEST_F(Interrupted, ByALimitOfFileSizes) {
  const std::filesystem::path asset = output() / "a.furrow";
  ASSERT_EQ(run(cookInto(asset, small)).status, 0);
  const std::string old = readText(asset);
  rlimit limit{};
  ::getrlimit(RLIMIT_FSIZE, &limit);
  const rlimit unlimited = limit;
  limit.rlim_cur = old.size() + 4096;
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);  // of the tool, which inherits it
  const Outcome outcome = run(cookInto(asset, large));
  ::setrlimit(RLIMIT_FSIZE, &unlimited);
  expectNoRoom(output(), "File too large", outcome, old);
}

}  // namespace
}  // namespace furrow::test
