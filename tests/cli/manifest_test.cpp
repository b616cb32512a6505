// furrow cook --manifest and the cache: many cooks, none done twice, none lost.

#include <signal.h>

#include "tests/cli/sheet.h"
#include "tests/cli/tool.h"

namespace furrow::test {
namespace {

constexpr const char* kSheet =
    "v 0 0 0\nv 1 0 0\nv 2 0 0.1\nv 0 1 0\nv 1 1 0\nv 2 1 0.1\n"
    "vt 0 0\nvt 0.5 0\nvt 1 0\nvt 0 1\nvt 0.5 1\nvt 1 1\n"
    "f 1/1 2/2 5/5 4/4\nf 2/2 3/3 6/6 5/5\n";
constexpr const char* kPlain = R"({"layers": [{"name": "a", "compress": "none"}]})";
constexpr const char* kMapped =
    R"({"layers": [{"name": "a", "direction": {"axis": [1, 0, 0]}, "compress": {"height": "map.pgm"}}]})";
constexpr const char* kMap = "P2\n4 4\n255\n0 60 200 60\n0 60 200 60\n0 60 200 60\n0 60 200 60\n";

class Manifest : public ToolTest {
 protected:
  Manifest() {
    std::filesystem::create_directory(folder() / "art");
    write("art/one.obj", kSheet);
    write("art/two.obj", kSheet);
    write("art/plain.json", kPlain);
    write("art/mapped.json", kMapped);
    write("art/map.pgm", kMap);
    write("art/assets.json", R"({"assets": [
      {"source": "one.obj", "recipe": "plain.json", "output": "../output/new/one.furrow"},  // folders are made
      {"source": "two.obj", "recipe": "mapped.json", "output": "../output/two.furrow", "geometry": "raw"}]})");
    for (const auto& entry : std::filesystem::directory_iterator(folder() / "art")) age(entry.path(), 60);
  }

  // Written so many seconds ago, which the coarsest file system tells from now.
  static void age(const std::filesystem::path& file, int seconds) {
    std::filesystem::last_write_time(
        file, std::filesystem::file_time_type::clock::now() - std::chrono::seconds(seconds));
  }

  Outcome cook(std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"cook", "--manifest", manifest, "--cache", cache});
    return run(more);
  }

  // The last line, without its time.
  static std::string summary(const Outcome& outcome) {
    const size_t begin = outcome.err.rfind("furrow: ");
    return outcome.err.substr(begin, outcome.err.rfind(", ") - begin);
  }

  void expectNoTemporaries(const std::filesystem::path& where) const {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(where))
      EXPECT_NE(entry.path().extension(), ".tmp") << entry.path();
  }

  std::filesystem::path manifest = folder() / "art/assets.json", cache = folder() / "cache",
                        one = output() / "new/one.furrow", two = output() / "two.furrow";
};

TEST_F(Manifest, CooksWhatASingleCookDoes) {
  const Outcome outcome = cook({"-j", "2"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(summary(outcome), "furrow: " + manifest.string() + ": 2 cooked");
  EXPECT_EQ(outcome.out, "");
  const std::filesystem::path single = output() / "single.furrow";
  ASSERT_EQ(
      run({"cook", folder() / "art/one.obj", "--recipe", folder() / "art/plain.json", "-o", single}).status,
      0);
  EXPECT_TRUE(readText(single) == readText(one));
  ASSERT_EQ(run({"cook", folder() / "art/two.obj", "--recipe", folder() / "art/mapped.json", "-o", single,
                 "--geometry", "raw"})
                .status,
            0);
  EXPECT_TRUE(readText(single) == readText(two));
}

TEST_F(Manifest, OnlyWhatChangedIsCookedAgain) {
  ASSERT_EQ(cook().status, 0);
  const std::string old_one = readText(one), old_two = readText(two);
  const auto before = std::filesystem::last_write_time(one);
  EXPECT_EQ(summary(cook()), "furrow: " + manifest.string() + ": 2 up to date");
  EXPECT_EQ(std::filesystem::last_write_time(one), before) << "what is right already is left alone";

  write("art/map.pgm", std::string(kMap).replace(0, 16, "P2\n4 4\n255\n90 60 "));
  EXPECT_EQ(summary(cook()), "furrow: " + manifest.string() + ": 1 cooked, 1 up to date");
  EXPECT_TRUE(readText(one) == old_one);
  EXPECT_FALSE(readText(two) == old_two);
  EXPECT_EQ(std::filesystem::last_write_time(one), before);

  write("art/map.pgm", kMap);
  EXPECT_EQ(summary(cook()), "furrow: " + manifest.string() + ": 1 from the cache, 1 up to date");
  EXPECT_TRUE(readText(two) == old_two);

  // Touched, as build systems see it: the time is new, the bytes are not.
  age(two, 40);
  age(folder() / "art/map.pgm", 20);
  EXPECT_EQ(summary(cook()), "furrow: " + manifest.string() + ": 1 from the cache, 1 up to date");
  EXPECT_GT(std::filesystem::last_write_time(two),
            std::filesystem::last_write_time(folder() / "art/map.pgm"));
  EXPECT_EQ(cook({"--quiet"}).err, "");
}

TEST_F(Manifest, GoesOnAfterAFailure) {
  ASSERT_EQ(cook().status, 0);
  const std::string old_two = readText(two);
  write("art/assets.json", R"({"assets": [
      {"source": "missing.obj", "output": "../output/missing.furrow"},
      {"source": "two.obj", "recipe": "bad.json", "output": "../output/two.furrow"},
      {"source": "map.pgm", "output": "../output/map.furrow"},
      {"source": "torn.glb", "output": "../output/torn.furrow"},
      {"source": "one.obj", "recipe": "plain.json", "output": "../output/good.furrow"}]})");
  write("art/bad.json", R"({"layers": [{"name": "a", "measur": "area"}]})");
  GltfBuilder torn;
  torn.add(std::vector<float>(9, 0.0f), "VEC3", 3);
  write("art/torn.glb", torn.glb(R"("scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":7}])"));
  const Outcome outcome = cook({"--quiet"});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 5) << outcome.err;
  for (const char* part :
       {"missing.obj: no such file: ", "bad.json: layers[0].measur: no such key: did you mean \"measure\"?",
        "map.pgm: not a format that furrow reads: ", "torn.glb: ",
        "assets.json: 4 of 5 assets failed (1 from the cache): see the lines above"})
    EXPECT_NE(outcome.err.find(part), std::string::npos) << part << '\n' << outcome.err;
  EXPECT_TRUE(readText(two) == old_two) << "the old asset stays";
  EXPECT_TRUE(std::filesystem::exists(output() / "good.furrow"));
  for (const char* none : {"missing", "map", "torn"})
    EXPECT_FALSE(std::filesystem::exists(output() / (std::string(none) + ".furrow")));
}

// A cook that dies takes none of the others with it.
TEST_F(Manifest, OutlivesACookThatIsKilled) {
  const auto children = [](const std::string& pid) { return "/proc/" + pid + "/task/" + pid + "/children"; };
  if (!std::filesystem::exists(children(std::to_string(::getpid()))))
    GTEST_SKIP() << "the system does not tell whose children processes are";
  write("art/one.obj", foldedSheet());  // it takes its time
  write("art/plain.json",
        R"({"mapSize": 2048, "layers": [{"name": "a", "direction": {"axis": [1, 0, 0]}}]})");
  const pid_t parent = start({"cook", "--manifest", manifest, "--no-cache", "-j", "1"}, FURROW_TOOL,
                             "/dev/null", folder() / "lines");
  ASSERT_GT(parent, 0);
  pid_t child = 0;
  int status = 0;
  while (!(std::ifstream(children(std::to_string(parent))) >> child) &&
         ::waitpid(parent, &status, WNOHANG) == 0)
    std::this_thread::yield();
  ASSERT_TRUE(child > 0 && ::kill(child, SIGKILL) == 0) << "the cook was over already";
  ASSERT_EQ(::waitpid(parent, &status, 0), parent);
  const std::string lines = readText(folder() / "lines");
  EXPECT_EQ(WEXITSTATUS(status), 1);
  EXPECT_NE(lines.find("one.furrow: its cook was ended by signal 9: run 'furrow cook' on it alone\n"),
            std::string::npos)
      << lines;
  EXPECT_NE(lines.find("1 of 2 assets failed (1 cooked)"), std::string::npos) << lines;
  EXPECT_FALSE(std::filesystem::exists(one));
  EXPECT_TRUE(std::filesystem::exists(two));
}

TEST_F(Manifest, TheDepfileNamesWhatEveryAssetIsMadeOf) {
  const std::filesystem::path depfile = output() / "assets.d";
  ASSERT_EQ(cook({"--depfile", depfile}).status, 0);
  const std::string art = (folder() / "art").string() + '/', line = " \\\n  " + art;
  EXPECT_EQ(readText(depfile), one.string() + ":" + line + "one.obj" + line + "plain.json" + line +
                                   "assets.json\n" + two.string() + ":" + line + "two.obj" + line +
                                   "mapped.json" + line + "map.pgm" + line + "assets.json\n");
}

TEST_F(Manifest, TheCacheServesOtherFoldersAndSingleCooks) {
  ASSERT_EQ(cook().status, 0);
  const std::filesystem::path elsewhere = folder() / "else where";
  std::filesystem::create_directory(elsewhere);
  std::filesystem::copy(folder() / "art", elsewhere / "art", std::filesystem::copy_options::recursive);
  manifest = elsewhere / "art/assets.json";
  const Outcome moved = cook();
  EXPECT_EQ(summary(moved), "furrow: " + manifest.string() + ": 2 from the cache") << moved.err;
  EXPECT_NE(moved.err.find("art/one.obj: warning: no clip"), std::string::npos) << "warnings are kept, too\n"
                                                                                << moved.err;
  EXPECT_TRUE(readText(elsewhere / "output/two.furrow") == readText(two));

  const std::filesystem::path single = output() / "single.furrow", depfile = output() / "single.d";
  const Outcome outcome = run({"cook", folder() / "art/two.obj", "--recipe", folder() / "art/mapped.json",
                               "-o", single, "--geometry", "raw", "--cache", cache, "--depfile", depfile});
  EXPECT_NE(outcome.err.find("single.furrow: from the cache, "), std::string::npos) << outcome.err;
  EXPECT_TRUE(readText(single) == readText(two));
  EXPECT_NE(readText(depfile).find("map.pgm"), std::string::npos);
}

// As when it is built anew meanwhile.
TEST_F(Manifest, AToolThatIsRemovedWhileItRunsStillKnowsItsCache) {
  const std::filesystem::path tool = folder() / "furrow";
  std::filesystem::copy_file(FURROW_TOOL, tool);
  const Outcome outcome =
      run({"-c", "exec 3<'" + tool.string() + "'; rm '" + tool.string() + "'; exec /proc/self/fd/3 cook '" +
                     (folder() / "art/one.obj").string() + "' -o '" + two.string() + "' --cache '" +
                     cache.string() + "' --quiet"},
          "/bin/sh");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
}

TEST_F(Manifest, ADamagedCacheIsCookedAnew) {
  ASSERT_EQ(cook().status, 0);
  const std::string right = readText(two);
  const auto rewritten = [](const auto& change) {
    return [change](const std::filesystem::path& entry) {
      std::string bytes = readText(entry);
      change(bytes);
      std::ofstream(entry, std::ios::binary) << bytes;
    };
  };
  const std::vector<std::function<void(const std::filesystem::path&)>> damages = {
      rewritten([](std::string& bytes) { bytes[bytes.size() - 9] ^= 1; }),  // in the asset
      rewritten([](std::string& bytes) { bytes[9] ^= 1; }),                 // in the lengths
      rewritten([](std::string& bytes) { bytes[23] ^= 1; }),
      rewritten([](std::string& bytes) { bytes.resize(bytes.size() / 2); }),
      rewritten([](std::string& bytes) { bytes.clear(); }),
      rewritten([](std::string& bytes) { bytes += '\0'; }),
      [](const std::filesystem::path& entry) { std::filesystem::resize_file(entry, uintmax_t{1} << 42); }};
  for (const auto& damage : damages) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(cache))
      if (entry.is_regular_file()) damage(entry.path());
    std::filesystem::remove(two);
    EXPECT_EQ(summary(cook()), "furrow: " + manifest.string() + ": 2 cooked");
    EXPECT_TRUE(readText(two) == right);
    EXPECT_EQ(summary(cook()), "furrow: " + manifest.string() + ": 2 up to date")
        << "the cook mends the entry";
  }
}

TEST_F(Manifest, CooksAtOnceDoNotDisturbEachOther) {
  std::vector<Outcome> outcomes(6);
  forEachInParallel(outcomes.size(), [&](size_t i) { outcomes[i] = cook({"-j", "2"}); });
  for (const Outcome& outcome : outcomes) EXPECT_EQ(outcome.status, 0) << outcome.err;
  expectNoTemporaries(folder());
  const std::string parallel = readText(two);
  EXPECT_EQ(cook({"--no-cache"}).status, 2) << "--cache and --no-cache";
  ASSERT_EQ(run({"cook", "--manifest", manifest, "--no-cache"}).status, 0);
  EXPECT_TRUE(readText(two) == parallel);
}

TEST_F(Manifest, ACacheThatCannotBeWrittenIsNoFailure) {
  cache = write("no folder", "");
  const Outcome outcome = cook();
  EXPECT_EQ(outcome.status, 0);
  EXPECT_NE(outcome.err.find("two.furrow: warning: not kept in the cache: "), std::string::npos)
      << outcome.err;
}

TEST_F(Manifest, ABadManifestSaysWhatIsWrong) {
  const auto refused = [&](const std::string& assets, const std::string& wrong) {
    write("art/assets.json", R"({"assets": )" + assets + "}");
    expectRefused(cook(), 1, "assets.json: " + wrong);
  };
  refused("[]", "assets: is a list of 0: give a list of one or more values");
  refused(R"([{"source": "one.obj"}])", "assets[0].output: is missing: give the path of a file");
  refused(R"([{"output": "one.furrow"}])", "assets[0] has no source: give \"source\", \"sequence\" or both");
  refused(R"([{"source": "one.obj", "outptu": "a"}])",
          "assets[0].outptu: no such key: did you mean \"output\"?");
  refused(R"([{"source": "one.obj\u0000", "output": "a"}])", "assets[0].source: has a zero byte: ");
  refused(R"([{"source": "one.obj", "fps": 3, "output": "a"}])", "assets[0].fps: does not go with");
  refused(R"([{"source": "one.obj", "output": "a", "geometry": "rwa"}])",
          "assets[0].geometry: is \"rwa\": give");
  refused(R"([{"source": "one.obj", "output": "a"}, {"source": "two.obj", "output": "b/../a"}])",
          "assets[1].output: is also the output of assets[0]: ");
  refused(R"([{"source": "one.obj", "output": "two.obj"}, {"source": "two.obj", "output": "a"}])",
          "assets[0].output: is an input of assets[1]: ");
  write("art/assets.json", R"({"assets": [)");
  expectRefused(cook(), 1, "assets.json: line 1, column 13: ");
  manifest = folder() / "none.json";
  expectRefused(cook(), 1, "none.json: no such file: check the path");
  expectRefused(cook({"-o", one}), 2, "--manifest");
  expectRefused(run({"cook", folder() / "art/one.obj", "-o", one, "-j", "2"}), 2, "--manifest");
  expectRefused(run({"cook", folder() / "art/one.obj"}), 2, "--output");
}

TEST_F(Manifest, SequencesAreCookedToo) {
  write("art/f_1.obj", kSheet);
  write("art/f_2.obj", std::string(kSheet).replace(0, 7, "v 0 0 1"));
  write(
      "art/assets.json",
      R"({"assets": [{"sequence": "f_*.obj", "fps": 12.5, "recipe": "plain.json", "output": "../output/f.furrow"}]})");
  const std::filesystem::path depfile = output() / "f.d", single = output() / "single.furrow";
  ASSERT_EQ(cook({"--depfile", depfile}).status, 0);
  ASSERT_EQ(run({"cook", "--sequence", folder() / "art/f_*.obj", "--fps", "12.5", "--recipe",
                 folder() / "art/plain.json", "-o", single})
                .status,
            0);
  EXPECT_TRUE(readText(output() / "f.furrow") == readText(single));
  EXPECT_NE(readText(depfile).find("f_2.obj"), std::string::npos);
  write("art/f_3.obj", kSheet);
  EXPECT_EQ(summary(cook()), "furrow: " + manifest.string() + ": 1 cooked")
      << "a frame more is another animation";
}

TEST_F(Manifest, FitsItsSchema) {
  if (!knowsSchemas()) GTEST_SKIP() << "python3-jsonschema is not installed";
  const std::filesystem::path schema = FURROW_SOURCE_DIR "/docs/manifest.schema.json";
  const std::string right = write("right.json", R"({"assets": [{"source": "a", "output": "b"}]})");
  const std::string wrong = write("wrong.json", R"({"assets": [{"sorce": "a", "output": "b"}]})");
  EXPECT_TRUE(validBySchema(schema, right));
  EXPECT_FALSE(validBySchema(schema, wrong));
}

}  // namespace
}  // namespace furrow::test
