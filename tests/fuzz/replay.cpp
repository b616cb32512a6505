// What runs a fuzz target where the build has no libFuzzer: every file of a folder, and mutations of them
// that are the same on every run. replay SEEDS [MUTATIONS]

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string_view>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace {

using Bytes = std::vector<uint8_t>;

class Mutator {
 public:
  explicit Mutator(const std::vector<Bytes>& seeds) : seeds_(seeds) {}

  Bytes next() {
    Bytes bytes = seeds_[below(seeds_.size())];
    for (size_t steps = 1 + below(4); steps > 0; --steps) change(bytes);
    return bytes;
  }

 private:
  size_t below(size_t count) { return random_() % count; }

  void change(Bytes& bytes) {
    if (bytes.empty()) return;
    const auto at = bytes.begin() + static_cast<ptrdiff_t>(below(bytes.size()));
    const auto length =
        static_cast<ptrdiff_t>(std::min<size_t>(1 + below(32), static_cast<size_t>(bytes.end() - at)));
    switch (below(6)) {
      case 0:
        *at = static_cast<uint8_t>(*at ^ (1u << below(8)));
        break;
      case 1:
        *at = static_cast<uint8_t>(random_());
        break;
      case 2:
        bytes.erase(at, at + length);
        break;
      case 3: {
        const Bytes copy(at, at + length);
        bytes.insert(at, copy.begin(), copy.end());
        break;
      }
      case 4: {  // a number of text becomes another
        constexpr const char* kNumbers[] = {"0", "-1", "1e39", "255", "65536", "4294967295", "1e-45", "nan"};
        const auto digit = std::find_if(at, bytes.end(), [](uint8_t c) { return c >= '0' && c <= '9'; });
        if (digit == bytes.end()) break;
        const std::string_view number = kNumbers[below(std::size(kNumbers))];
        bytes.insert(bytes.erase(digit), number.begin(), number.end());
        break;
      }
      default: {
        const Bytes& other = seeds_[below(seeds_.size())];
        if (other.empty()) break;
        const size_t from = below(other.size());
        bytes.erase(at, bytes.end());
        bytes.insert(bytes.end(), other.begin() + static_cast<ptrdiff_t>(from), other.end());
      }
    }
  }

  const std::vector<Bytes>& seeds_;
  std::mt19937 random_;
};

// What the target throws is a finding, and so is what ends this program.
bool survives(const Bytes& bytes) try {
  LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  return true;
} catch (const std::exception& error) {
  std::ofstream("finding", std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  std::fprintf(stderr, "%s; the input is in the file \"finding\"\n", error.what());
  return false;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::filesystem::path> files;
  if (argc > 1)
    for (const auto& entry : std::filesystem::directory_iterator(argv[1])) files.push_back(entry.path());
  if (files.empty()) {
    std::fputs("replay SEEDS [MUTATIONS]: there are no seeds\n", stderr);
    return 2;
  }
  std::sort(files.begin(), files.end());
  std::vector<Bytes> seeds;
  for (const auto& file : files) {
    std::ifstream in(file, std::ios::binary);
    seeds.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  if (!std::ranges::all_of(seeds, survives)) return 1;
  Mutator mutator(seeds);
  const int mutations = argc > 2 ? std::atoi(argv[2]) : 0;
  for (int i = 0; i < mutations; ++i)
    if (!survives(mutator.next())) return 1;
  std::printf("%zu seeds and %d mutations without a finding\n", seeds.size(), mutations);
  return 0;
}
