// game FILE...: loads assets, computes the weights of their rest pose and finds the shader text.

#include <cstdio>
#include <fstream>
#include <iterator>
#include <span>
#include <vector>

#include "furrow/asset.h"
#include "furrow/gl/executor.h"
#include "furrow/jobs.h"

namespace {

int fail(const char* what, const char* why) {
  std::printf("%s: %s\n", what, why);
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (!std::ifstream(SHADE)) return fail(SHADE, "missing");
  const furrow::gl::Executor executor;  // links; makes nothing yet
  for (int i = 1; i < argc; ++i) {
    std::ifstream in(argv[i], std::ios::binary);
    const std::vector<char> bytes((std::istreambuf_iterator<char>(in)), {});
    furrow::Asset asset;
    if (const furrow::Status status = asset.load(std::as_bytes(std::span(bytes))); !status.ok())
      return fail(argv[i], status.message);
    const furrow::AssetView& a = asset.view();
    std::vector<float> triangle_q(a.triangleCount()), point_q(a.pointCount());
    std::vector<int16_t> weights(a.vertexCount() * a.weightStride());
    furrow::CompressJob{&a, 0, a.positions, 1.0f, triangle_q}.run(0, a.triangleCount());
    furrow::SmoothJob{&a, triangle_q, point_q}.run(0, a.pointCount());
    furrow::RespondJob{&a, 0, a.layers[0].response, 0.0f, point_q, weights}.run(0, a.vertexCount());
    for (int16_t weight : weights)
      if (weight < -1 || weight > 1) return fail(argv[i], "has weights at rest");
    if (a.texture_sets.empty() || a.texture_sets[0].normals.slices == 0) return fail(argv[i], "has no maps");
  }
  return 0;
}
