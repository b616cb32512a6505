#pragma once

#include <cmath>
#include <string>

namespace furrow::test {

// A folded sheet with UVs, about 900 triangles.
inline std::string foldedSheet() {
  constexpr int kQuads = 21;
  std::string vertices, uvs, faces;
  for (int y = 0; y <= kQuads; ++y)
    for (int x = 0; x <= kQuads; ++x) {
      const double u = static_cast<double>(x) / kQuads, v = static_cast<double>(y) / kQuads;
      vertices += "v " + std::to_string(u) + ' ' + std::to_string(v) + ' ' +
                  std::to_string(0.1 * std::sin(9.0 * u) * std::cos(5.0 * v)) + '\n';
      uvs += "vt " + std::to_string(u) + ' ' + std::to_string(v) + '\n';
    }
  const auto corner = [](int i) { return ' ' + std::to_string(i) + '/' + std::to_string(i); };
  for (int y = 0; y < kQuads; ++y)
    for (int x = 0; x < kQuads; ++x) {
      const int a = y * (kQuads + 1) + x + 1, c = a + kQuads + 1;
      faces += 'f' + corner(a) + corner(a + 1) + corner(c + 1) + "\nf" + corner(a) + corner(c + 1) +
               corner(c) + '\n';
    }
  return vertices + uvs + faces;
}

}  // namespace furrow::test
