// game FILE: loads an asset and says why it does not load.

#include <cstdio>
#include <fstream>
#include <iterator>
#include <span>
#include <vector>

#include "furrow/asset.h"

int main(int argc, char** argv) {
  std::ifstream in(argc > 1 ? argv[1] : "", std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(in)), {});
  furrow::Asset asset;
  const furrow::Status status = asset.load(std::as_bytes(std::span(bytes)));
  if (!status.ok()) std::printf("%s\n", status.message);
  return status.ok() ? 0 : 1;
}
