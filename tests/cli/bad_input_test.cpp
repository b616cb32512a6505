// What the tool does with files, recipes and options that will not do: one line, the documented status,
// nothing left behind.

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <limits>

#include "runtime/src/asset_header.h"
#include "tests/cli/tool.h"

namespace furrow::test {
namespace {

const std::vector<float> kSquare = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
const std::vector<uint16_t> kTriangles = {0, 1, 2, 0, 2, 3};

// A scene of one mesh whose primitive has these members.
std::string scene(const std::string& primitive, const std::string& more = "") {
  return R"("scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{)" + primitive +
         "}]}]" + more;
}

std::string sheet(const std::vector<float>& positions = kSquare,
                  const std::vector<uint16_t>& indices = kTriangles, const std::string& more = "") {
  GltfBuilder builder;
  builder.add(positions, "VEC3", 3);
  builder.add(indices, "SCALAR", 1);
  return builder.glb(scene(R"("attributes":{"POSITION":0},"indices":1)", more));
}

std::string blackSheet() {
  GltfBuilder builder;
  builder.add(kSquare, "VEC3", 3);
  builder.add(kTriangles, "SCALAR", 1);
  builder.add(std::vector<float>(16, 0.0f), "VEC4", 4);
  return builder.glb(scene(R"("attributes":{"POSITION":0,"COLOR_0":2},"indices":1)"));
}

std::string unwrappedSheet() {
  GltfBuilder builder;
  builder.add(kSquare, "VEC3", 3);
  builder.add(kTriangles, "SCALAR", 1);
  builder.add(std::vector<float>{0, 1, 1, 1, 1, 0, 0, 0}, "VEC2", 2);
  return builder.glb(scene(R"("attributes":{"POSITION":0,"TEXCOORD_0":2},"indices":1)"));
}

class BadInput : public ToolTest {
 protected:
  Outcome cook(const std::filesystem::path& source, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"cook", source, "-o", output() / "out.furrow"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }

  // Every command that reads a source refuses it.
  void expectBadSource(const std::filesystem::path& source) const {
    const std::vector<std::vector<std::string>> commands = {
        {"cook", source, "-o", output() / "out.furrow"},
        {"check", source},
        {"info", source},
        {"eval", source, "--backend", "cpu", "-o", output() / "out.csv"}};
    forEachInParallel(commands.size(), [&](size_t i) { expectOneLine(run(commands[i]), 1, source); });
    expectNothingLeft();
  }

  void expectBadRecipe(const std::string& source, const std::string& recipe, const std::string& named) const {
    expectRefused(cook(write("sheet.glb", source), {"--recipe", write("recipe.json", recipe)}), 1, named);
  }
};

TEST_F(BadInput, TheSheetItselfIsFine) {
  const Outcome outcome = cook(write("sheet.glb", sheet()), {"--quiet"});
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.err, "");
  EXPECT_TRUE(std::filesystem::exists(output() / "out.furrow"));
  EXPECT_EQ(run({"check", output() / "out.furrow"}).status, 0);
}

TEST_F(BadInput, MissingFile) {
  expectBadSource(folder() / "missing.glb");
}
TEST_F(BadInput, MissingAsset) {
  expectRefused(run({"check", folder() / "missing.furrow"}), 1, folder() / "missing.furrow");
}
TEST_F(BadInput, Folder) {
  std::filesystem::create_directory(folder() / "folder.glb");
  expectBadSource(folder() / "folder.glb");
}
// A pipe that nobody writes to never ends: every file that can be named must be a regular one.
TEST_F(BadInput, Pipe) {
  const auto pipe = [&](const char* name) {
    const std::filesystem::path file = folder() / name;
    EXPECT_EQ(mkfifo(file.c_str(), 0600), 0);
    return file;
  };
  const std::string source = write("sheet.glb", sheet()), out = output() / "out.furrow";
  GltfBuilder builder;
  builder.add(kSquare, "VEC3", 3);
  const std::vector<std::pair<std::string, std::vector<std::string>>> commands = {
      {"mesh.glb", {"cook", pipe("mesh.glb"), "-o", out}},
      {"recipe.json", {"cook", source, "-o", out, "--recipe", pipe("recipe.json")}},
      {"mask.png",
       {"cook", source, "-o", out, "--recipe",
        write("named.json",
              R"({"layers": [{"name": "a", "mask": {"texture": ")" + pipe("mask.png").string() + "\"}}]}")}},
      {"sheet.bin",
       {"cook",
        write("sheet.gltf",
              builder.json(scene(R"("attributes":{"POSITION":0})"), pipe("sheet.bin").filename())),
        "-o", out}},
      {"assets.json", {"cook", "--manifest", pipe("assets.json"), "--no-cache"}},
      {"asset.furrow", {"check", pipe("asset.furrow")}},
      {"take.csv", {"eval", source, "--take", pipe("take.csv"), "-o", output() / "out.csv"}},
      {"mesh.bin", {"check", pipe("mesh.bin")}}};
  forEachInParallel(commands.size(), [&](size_t i) {
    std::vector<std::string> patient = {"20", FURROW_TOOL};
    patient.insert(patient.end(), commands[i].second.begin(), commands[i].second.end());
    expectOneLine(run(patient, "/usr/bin/timeout"), 1, commands[i].first);
  });
  expectNothingLeft();
}
TEST_F(BadInput, EmptyFile) {
  expectBadSource(write("empty.glb", ""));
  expectBadSource(write("empty.gltf", ""));
  expectRefused(run({"check", write("empty.furrow", "")}), 1, "empty.furrow");
}
TEST_F(BadInput, NotAMesh) {
  expectBadSource(write("words.glb", "These are words.\nNot a mesh.\n"));
  expectBadSource(write("words.gltf", "{\"words\": \"a\nb\"}"));
  expectBadSource(write("array.gltf", "[1, 2, 3]"));
}
TEST_F(BadInput, TruncatedBinary) {
  const std::string whole = sheet();
  for (size_t length : {4u, 11u, 12u, 19u, 20u, 60u})
    expectBadSource(write("cut.glb", whole.substr(0, length)));
  expectBadSource(write("cut.glb", whole.substr(0, whole.size() - 8)));
}
TEST_F(BadInput, MissingBuffer) {
  GltfBuilder builder;
  builder.add(kSquare, "VEC3", 3);
  expectBadSource(write("alone.gltf", builder.json(scene(R"("attributes":{"POSITION":0})"), "missing.bin")));
}
TEST_F(BadInput, IndexOutOfRange) {
  expectBadSource(write("index.glb", sheet(kSquare, {0, 1, 2, 0, 2, 4})));
}
TEST_F(BadInput, PositionsThatAreNoNumbers) {
  for (float bad : {std::nanf(""), std::numeric_limits<float>::infinity()}) {
    std::vector<float> positions = kSquare;
    positions[4] = bad;
    expectBadSource(write("nan.glb", sheet(positions)));
  }
}
TEST_F(BadInput, PositionsBeyondAllMeasure) {
  std::vector<float> positions = kSquare;
  positions[3] = 3e38f;
  expectBadSource(write("far.glb", sheet(positions)));
  const std::string node = R"({"mesh":0})", far = R"({"mesh":0,"scale":[1e38,1,1]})";
  GltfBuilder builder;
  builder.add(kSquare, "VEC3", 3);
  builder.add(kTriangles, "SCALAR", 1);
  std::string text = scene(R"("attributes":{"POSITION":0},"indices":1)");
  text.replace(text.find(node), node.size(), far);
  expectBadSource(write("scaled.glb", builder.glb(text)));
}
TEST_F(BadInput, NoTriangles) {
  GltfBuilder builder;
  builder.add(kSquare, "VEC3", 3);
  expectBadSource(write("points.glb", builder.glb(scene(R"("attributes":{"POSITION":0},"mode":0)"))));
  expectBadSource(write("empty_scene.gltf", R"({"asset":{"version":"2.0"},"scenes":[{}],"scene":0})"));
}
TEST_F(BadInput, RequiredExtensionNobodyKnows) {
  const std::string more = R"(,"extensionsUsed":["ACME_folds"],"extensionsRequired":["ACME_folds"])";
  const std::filesystem::path file = write("acme.glb", sheet(kSquare, kTriangles, more));
  expectBadSource(file);
  EXPECT_NE(cook(file).err.find("ACME_folds"), std::string::npos);
}

TEST_F(BadInput, RecipeThatIsMissing) {
  expectRefused(cook(write("sheet.glb", sheet()), {"--recipe", folder() / "none.json"}), 1, "none.json");
}
TEST_F(BadInput, RecipeThatIsNoJson) {
  expectBadRecipe(sheet(), "", "recipe.json");
  expectBadRecipe(sheet(), "{\"layers\": [\n  {\"name\": \"a\",}\n]}", "recipe.json");
}
TEST_F(BadInput, RecipeWithAKeyNobodyKnows) {
  expectBadRecipe(sheet(), R"({"layers": [{"name": "a", "direktion": "animation"}]})", "recipe.json");
  EXPECT_NE(cook(folder() / "sheet.glb", {"--recipe", folder() / "recipe.json"}).err.find("\"direction\""),
            std::string::npos);
}
TEST_F(BadInput, DirectionsThatCannotBeHad) {
  const auto expectFault = [&](const std::string& direction, const std::string& named) {
    const std::string text = R"({"layers": [{"name": "a", "direction": )" + direction + "}]}";
    expectBadRecipe(sheet(), text, "recipe.json");
    EXPECT_NE(cook(folder() / "sheet.glb", {"--recipe", folder() / "recipe.json"}).err.find(named),
              std::string::npos)
        << named;
  };
  write("flow.png", "not an image");
  expectFault(R"({"guides": [[[0, 0, 0]]]})", "guides[0]");
  expectFault(R"({"guides": [[[0, 0.5, 0], [1, 0.5, NaN]]]})", "line 1");
  expectFault(R"({"guides": [[[0, 0.5, 0], [0, 0.5, 0]]]})", "no length");
  expectFault(R"({"guides": [[[0, 0.5, 0], [1, 0.5, 2]]]})", "(1, 0.5, 2) is 2 from");
  expectFault(R"({"guides": {"lines": "Creases"}})", "\"Creases\"");
  expectFault(R"({"texture": "missing.png"})", "missing.png");
  expectFault(R"({"texture": "flow.png"})", "no UVs");
  expectFault(R"("map")", "\"compress\" names no image");
}
TEST_F(BadInput, RecipeNamingAMissingTexture) {
  expectBadRecipe(sheet(),
                  R"({"layers": [{"name": "a", "mask": {"texture": "missing.png", "channel": "r"}}]})",
                  "missing.png");
}
TEST_F(BadInput, RecipeNamingATextureThatIsNone) {
  write("words.png", "no picture");
  expectBadRecipe(sheet(), R"({"layers": [{"name": "a", "mask": {"texture": "words.png", "channel": "r"}}]})",
                  "words.png");
}
// libpng says on stderr what OpenImageIO hands on, too.
TEST_F(BadInput, RecipeNamingAnImageOfNoTexels) {
  using namespace std::string_literals;
  write("none.png", "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\0\0\0\0\0\x08\0\0\0\0\x1e\xe0\x23\xce"s);
  expectBadRecipe(sheet(), R"({"layers": [{"name": "a", "mask": {"texture": "none.png"}}]})", "none.png");
}
TEST_F(BadInput, ASpacingTooSmallForTheSurfaceNamesItsLayer) {
  expectBadRecipe(unwrappedSheet(),
                  R"({"layers": [{"name": "lines", "compress": {"synthesize": {"spacing": 1e-9}}}]})",
                  "layer \"lines\": a wrinkle spacing of 1e-09");
}
TEST_F(BadInput, TheModuleForImagesIsMissing) {
  namespace fs = std::filesystem;
  const fs::path built = fs::path(FURROW_TOOL).parent_path(), tool = folder() / "bin/furrow";
  fs::create_directories(folder() / "bin");
  fs::copy_file(FURROW_TOOL, tool);
  write("words.png", "no picture");
  const std::vector<std::string> cook = {
      "cook",
      write("sheet.glb", sheet()),
      "-o",
      output() / "out.furrow",
      "--recipe",
      write("recipe.json",
            R"({"layers": [{"name": "a", "mask": {"texture": "words.png", "channel": "r"}}]})")};
  expectRefused(run(cook, tool), 3, "bin/furrow_images.so");
  fs::create_directories(folder() / "lib/furrow");
  fs::copy_file(built / "furrow_images.so", folder() / "lib/furrow/furrow_images.so");
  expectRefused(run(cook, tool), 1, "words.png");
}
TEST_F(BadInput, RecipeNamingAMeshOrAttributeThatIsNone) {
  expectBadRecipe(sheet(), R"({"layers": [{"name": "a", "meshes": ["Nose"]}]})", "Nose");
  expectBadRecipe(sheet(), R"({"layers": [{"name": "a", "mask": {"attribute": "_MASK", "channel": "r"}}]})",
                  "_MASK");
}
TEST_F(BadInput, EmptyMask) {
  expectBadRecipe(blackSheet(),
                  R"({"layers": [{"name": "brow", "mask": {"attribute": "COLOR_0", "channel": "r"}}]})",
                  "brow");
}

TEST_F(BadInput, OutputThatCannotBeWritten) {
  const std::string source = write("sheet.glb", sheet()), target = folder() / "nowhere/out.furrow";
  expectRefused(run({"cook", source, "-o", target, "--quiet"}), 3, target);
  EXPECT_FALSE(std::filesystem::exists(folder() / "nowhere"));
  expectRefused(run({"cook", source, "-o", output(), "--quiet"}), 3, output());
  const std::string asset = folder() / "sheet.furrow";
  ASSERT_EQ(run({"cook", source, "-o", asset, "--quiet"}).status, 0);
  expectRefused(run({"eval", asset, "--backend", "cpu", "-o", folder() / "nowhere/out.csv"}), 3, "out.csv");
}

TEST_F(BadInput, StandardOutputThatIsFull) {
  const std::string source = write("sheet.glb", sheet());
  for (const std::string& command :
       std::vector<std::string>{"info", "check", "eval --backend cpu", "bind '" + source + "'"}) {
    const std::string line = "'" FURROW_TOOL "' " + command + " '" + source + "' >/dev/full 2>/dev/null";
    EXPECT_EQ(WEXITSTATUS(std::system(line.c_str())), 3) << command;
  }
}

TEST_F(BadInput, OutputsAreRefusedBeforeTheSourceIsRead) {
  const std::string source = write("sheet.glb", "no mesh"), nowhere = folder() / "nowhere";
  for (const char* option : {"--init", "--depfile", "--report"})
    expectRefused(cook(source, {option, nowhere + "/r"}), 3, nowhere + "/r: cannot be written");
  expectRefused(run({"cook", source, "-o", source}), 2, "overwrite an input");
  expectRefused(run({"eval", source, "-o", nowhere + "/w.csv"}), 3, nowhere);
  expectRefused(run({"bind", source, source, "-o", nowhere + "/p.csv"}), 3, nowhere);
  expectRefused(run({"export", source, "-o", nowhere + "/a.glb"}), 3, nowhere);
  expectRefused(run({"render", source, "-o", nowhere + "/a.png"}), 3, nowhere);
  expectRefused(run({"render", source, "-o", output() / "a.jpg"}), 2, "ends in .png");
}
TEST_F(BadInput, OutputOverTheInput) {
  const std::filesystem::path source = write("sheet.glb", sheet());
  expectRefused(run({"cook", source, "-o", source}), 2, source);
  EXPECT_EQ(readText(source), sheet());
  const std::filesystem::path asset = folder() / "sheet.furrow", take = write("take.csv", "a take"),
                              recipe = write("recipe.json", R"({"layers": [{"name": "a"}]})");
  ASSERT_EQ(run({"cook", source, "-o", asset, "--quiet"}).status, 0);
  const std::string cooked = readText(asset), written = readText(recipe);
  for (const char* option : {"--init", "--depfile", "--report"})
    expectRefused(cook(source, {"--recipe", recipe, option, recipe, "--quiet"}), 2, recipe);
  EXPECT_EQ(readText(recipe), written);
  for (const std::filesystem::path& input : {asset, take})
    expectRefused(run({"eval", asset, "--backend", "cpu", "--take", take, "-o", input}), 2, input);
  EXPECT_EQ(readText(asset), cooked);
  const std::filesystem::path manifest =
      write("assets.json", R"({"assets": [{"source": "sheet.glb", "output": "a.furrow"}]})");
  expectRefused(run({"cook", "--manifest", manifest, "--no-cache", "--depfile", manifest}), 2, manifest);
}
TEST_F(BadInput, TwoOutputsOfOneName) {
  const std::string source = write("sheet.glb", sheet()), out = output() / "out.furrow";
  expectRefused(cook(source, {"--report", out, "--quiet"}), 2, out);
  EXPECT_EQ(cook(source, {"--report", "/dev/null", "--depfile", "/dev/null", "--quiet"}).status, 0);
}
TEST_F(BadInput, AFailedCookKeepsTheOldAsset) {
  const std::filesystem::path old = write("old.furrow", "an older asset");
  expectRefused(run({"cook", write("index.glb", sheet(kSquare, {0, 1, 4})), "-o", old}), 1, "index.glb");
  EXPECT_EQ(readText(old), "an older asset");
}

class DamagedAsset : public BadInput {
 protected:
  DamagedAsset() {
    EXPECT_EQ(cook(write("sheet.glb", sheet())).status, 0);
    whole_ = readText(output() / "out.furrow");
    std::filesystem::remove(output() / "out.furrow");
  }

  void expectDamaged(const std::string& bytes, const std::string& name = "damaged.furrow") const {
    const std::filesystem::path file = write(name, bytes);
    expectOneLine(run({"check", file}), 1, file);
  }

  std::string whole_;
};

TEST_F(DamagedAsset, AnyByteChanged) {
  ASSERT_GT(whole_.size(), sizeof(AssetHeader));
  const size_t payload = whole_.size() - sizeof(AssetHeader);
  std::vector<size_t> offsets;
  for (size_t i = 0; i < sizeof(AssetHeader); ++i) offsets.push_back(i);
  for (size_t i = 0; i < 150; ++i) offsets.push_back(sizeof(AssetHeader) + i * (payload - 1) / 149);
  forEachInParallel(offsets.size(), [&](size_t i) {
    SCOPED_TRACE("byte " + std::to_string(offsets[i]));
    std::string bytes = whole_;
    bytes[offsets[i]] = static_cast<char>(bytes[offsets[i]] ^ (1 << offsets[i] % 8));
    expectDamaged(bytes, "changed_" + std::to_string(offsets[i]) + ".furrow");
  });
  expectNothingLeft();
}

TEST_F(DamagedAsset, CutOrGrown) {
  const size_t header = sizeof(AssetHeader), size = whole_.size();
  for (size_t length : {size_t{0}, size_t{1}, size_t{5}, size_t{6}, header - 1, header, header + 1, size / 4,
                        size / 2, size - 4096, size - 1}) {
    if (length >= size) continue;
    SCOPED_TRACE("cut to " + std::to_string(length));
    expectDamaged(whole_.substr(0, length));
  }
  expectDamaged(whole_ + '\0');
}

TEST_F(DamagedAsset, EveryCommandRefuses) {
  std::string bytes = whole_;
  bytes[bytes.size() / 2] ^= 1;
  const std::filesystem::path file = write("damaged.furrow", bytes);
  expectRefused(run({"info", file}), 1, file);
  expectRefused(run({"eval", file, "--backend", "cpu", "-o", output() / "out.csv"}), 1, file);
  expectRefused(run({"render", file, "-o", output() / "out.png"}), 1, file);
}

TEST_F(BadInput, Usage) {
  const std::string source = write("sheet.glb", sheet()), asset = folder() / "sheet.furrow";
  ASSERT_EQ(run({"cook", source, "-o", asset, "--quiet"}).status, 0);
  const std::vector<std::vector<std::string>> commands = {
      {},
      {"fold", source},
      {"cook"},
      {"cook", source},
      {"cook", source, "-o", output() / "out.furrow", "--fast"},
      {"cook", source, "-o", output() / "out.furrow", "--geometry", "zip"},
      {"cook", source, "-o", output() / "out.furrow", "--threads", "0"},
      {"check"},
      {"check", source, source},
      {"cook", source, "-o", "-"},
      {"cook", source, "-o", output() / "out.furrow", "--report", "-"},
      {"eval", asset, "--backend", "cpu", "-o", "-"},
      {"render", asset, "-o", "-"},
      {"export", asset, "-o", "-"},
      {"bind", asset, source, "-o", "-"},
      {"info", asset, "--recipe", write("recipe.json", R"({"layers": [{"name": "a"}]})")},
      {"eval", asset, "--backend", "cpu", "--morph", "nonsense"},
      {"eval", asset, "--backend", "cpu", "--morph", "smile=much"},
      {"eval", asset, "--backend", "cpu", "--morph", "smile=nan"},
      {"eval", asset, "--backend", "cpu", "--morph", "smile=1"},
      {"eval", asset, "--backend", "cpu", "--region", "nose=1"},
      {"eval", asset, "--backend", "cpu", "--clip", "walk"},
      {"eval", asset, "--backend", "cpu", "--clip", "0"},
      {"eval", asset, "--backend", "cpu", "--clip", ""},
      {"eval", asset, "--backend", "cpu", "--time", "1"},
      {"eval", asset, "--backend", "cpu", "--region", "wrinkles=1.5"},
      {"eval", asset, "--scale", "nan"},
      {"eval", asset, "--backend", "cpu", "--scale", "0"},
      {"eval", asset, "--backend", "cpu", "--scale", "nan"},
      {"eval", asset, "--backend", "cpu", "--scale", "inf"},
      {"eval", asset, "--backend", "cpu", "--region", "0=1e39"},
      {"eval", asset, "--backend", "cpu", "--take", source, "--time", "nan"},
      {"eval", asset, "--backend", "abacus"},
      {"render", asset, "-o", output() / "out.png", "--yaw", "nan"},
      {"render", asset, "-o", output() / "out.png", "--zoom", "nan"},
      {"render", asset, "-o", output() / "out.png", "--target", "0", "nan", "0"},
      {"render", asset, "-o", output() / "out.png", "--size", "0x10"},
      {"render", asset, "-o", output() / "out.png", "--size", "big"},
      {"render", asset, "-o", output() / "out.png", "--yaw", "nan"},
      {"render", asset, "-o", output() / "out.png", "--zoom", "nan"},
      {"render", asset, "-o", output() / "out.png", "--target", "0", "inf", "0"},
      // Before the asset is opened.
      {"eval", folder() / "missing.furrow", "--morph", "nonsense"},
      {"render", folder() / "missing.furrow", "-o", output() / "out.png", "--region", "=1"},
  };
  forEachInParallel(commands.size(), [&](size_t i) {
    std::string text = "furrow";
    for (const std::string& word : commands[i]) text += " " + word;
    SCOPED_TRACE(text);
    expectOneLine(run(commands[i]), 2, "");
  });
  expectNothingLeft();
}

// For the runs of the tool in a scope.
class Environment {
 public:
  Environment(const char* name, const char* value) : name_(name) { setenv(name, value, 1); }
  ~Environment() { unsetenv(name_); }

 private:
  const char* name_;
};

TEST_F(BadInput, ABackendThatIsNotThere) {
  const std::string asset = folder() / "sheet.furrow";
  ASSERT_EQ(run({"cook", write("sheet.glb", sheet()), "-o", asset, "--quiet"}).status, 0);
  const Environment old_driver("MESA_GL_VERSION_OVERRIDE", "3.3");
  for (const std::string& file : {asset, std::string(folder() / "missing.furrow")})
    expectRefused(run({"eval", file, "--backend", "gpu", "-o", output() / "out.csv"}), 3, "needs OpenGL 4.3");
  const Environment no_driver("LIBGL_DRIVERS_PATH", "/nowhere"), silent("EGL_LOG_LEVEL", "fatal");
  for (const char* backend : {"gpu", "gpu-raster"}) {
    expectRefused(run({"eval", asset, "--backend", backend, "-o", output() / "out.csv"}), 3, backend);
    const Environment forced("FURROW_BACKEND", backend);
    expectRefused(run({"eval", asset, "-o", output() / "out.csv"}), 3, backend);
    // What describes an asset says so and goes on.
    const Outcome described = run({"info", asset, "--tier"});
    EXPECT_EQ(described.status, 0);
    EXPECT_THAT(described.out, testing::HasSubstr("tier here: the " + std::string(backend) +
                                                  " tier is not available: OpenGL: no context"));
    EXPECT_THAT(run({"info", asset, "--json", "--tier"}).out, testing::HasSubstr("\"name\": null"));
  }
  EXPECT_THAT(run({"info", asset, "--tier"}).out, testing::HasSubstr("tier here: cpu: OpenGL: no context"));
  const Outcome fallen = run({"eval", asset});
  EXPECT_EQ(fallen.status, 0);
  EXPECT_NE(fallen.err.find("using the tier cpu: "), std::string::npos) << fallen.err;
}

TEST_F(BadInput, TheEnvironmentForcesATier) {
  const std::string asset = folder() / "sheet.furrow";
  ASSERT_EQ(run({"cook", write("sheet.glb", sheet()), "-o", asset, "--quiet"}).status, 0);
  const Environment nonsense("FURROW_BACKEND", "abacus");
  expectRefused(run({"eval", asset, "-o", output() / "out.csv"}), 2, "auto, gpu, gpu-raster or cpu");
  expectOneLine(run({"info", asset, "--tier"}), 2, "auto, gpu, gpu-raster or cpu");
  EXPECT_EQ(run({"info", asset}).status, 0);  // asks no driver
  // An option says it louder.
  EXPECT_EQ(run({"eval", asset, "--backend", "cpu"}).status, 0);
  const Environment cpu("FURROW_BACKEND", "cpu");
  EXPECT_THAT(run({"info", asset, "--tier"}).out, testing::HasSubstr("tier here: cpu, as asked for"));
}

TEST_F(BadInput, AFaultStandsWithoutTheWarningsOfTheCook) {
  const std::filesystem::path source = write("sheet.glb", sheet());
  EXPECT_NE(run({"check", source}).err.find("warning: a mesh has no UVs"), std::string::npos);
  expectOneLine(run({"eval", source, "--backend", "cpu", "--clip", "walk"}), 2, source);
  expectRefused(run({"cook", source, "-o", folder() / "nowhere/out.furrow"}), 3, "out.furrow");
}

TEST_F(BadInput, HelpAndVersion) {
  for (const char* command : {"cook", "info", "check", "eval", "render"}) {
    const Outcome help = run({command, "--help"});
    EXPECT_EQ(help.status, 0);
    EXPECT_NE(help.out, "");
    EXPECT_EQ(help.err, "");
  }
  EXPECT_EQ(run({"--help"}).status, 0);
  EXPECT_NE(run({"--help"}).out.find("Exit status"), std::string::npos);
  EXPECT_NE(run({"--help"}).out.find("Usage: furrow "), std::string::npos);
  EXPECT_TRUE(run({"--version"}).out.starts_with("furrow "));
}

}  // namespace
}  // namespace furrow::test
