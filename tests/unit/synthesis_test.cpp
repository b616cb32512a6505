#include "pipeline/maps/synthesis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <random>
#include <stdexcept>

#include "pipeline/maps/kernels.h"
#include "tests/unit/surfaces.h"

namespace furrow::pipeline {
namespace {

using tests::along;
using tests::grid;

// The unit square in z = 0, seen from +z; u along +x, v along -y.
Surface sheet(uint32_t cells = 16) {
  return grid(
      cells, cells, [](double u, double v) { return glm::vec3(u, 1.0 - v, 0.0); },
      [](double, double) { return glm::vec3(0, 0, 1); });
}

const std::vector<uint32_t> kPart = {0};

SynthesizedMaps draw(const Surface& surface, const LayerField& field, const SynthesisSettings& settings,
                     uint32_t size, uint32_t threads = 2) {
  return Synthesis(surface, field, settings)
      .draw(mapTexels(surface, chartsOf(surface, kPart), {size, size}, 4), threads);
}

SynthesisSettings skin(double spacing) {
  return {Preset::kSkin, spacing, spacing / 8.0, 1};
}

// The period, in texels, at which the spectrum over the rows (or columns) peaks.
double period(const Image& height, bool along_x) {
  double best = 0.0, best_power = 0.0;
  for (double frequency = 2.0; frequency < height.width / 8.0; frequency += 0.25) {
    double power = 0.0;
    for (uint32_t line = 0; line < height.width; line += 8) {
      double real = 0.0, imaginary = 0.0;
      for (uint32_t i = 0; i < height.width; ++i) {
        const double angle = 2.0 * std::numbers::pi * frequency * i / height.width;
        const double h = along_x ? height.at(i, line)[0] : height.at(line, i)[0];
        real += h * std::cos(angle);
        imaginary += h * std::sin(angle);
      }
      power += real * real + imaginary * imaginary;
    }
    if (power > best_power) {
      best_power = power;
      best = frequency;
    }
  }
  return height.width / best;
}

class Presets : public testing::TestWithParam<Preset> {};
std::string nameOf(const testing::TestParamInfo<Preset>& preset) {
  const std::vector<std::string> names = {"skin", "skin_fine", "cloth", "cloth_puckers"};
  return names.at(static_cast<size_t>(preset.param));
}

INSTANTIATE_TEST_SUITE_P(, Presets,
                         testing::Values(Preset::kSkin, Preset::kSkinFine, Preset::kCloth,
                                         Preset::kClothPuckers),
                         nameOf);

TEST_P(Presets, RidgesLieAcrossTheDirectionAtTheirSpacing) {
  const Surface surface = sheet();
  for (const double spacing : {0.04, 0.06}) {
    for (const bool x : {true, false}) {
      const auto field = along(surface, x ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0));
      const Image height = draw(surface, field, {GetParam(), spacing, 0.1 * spacing, 3}, 256).height;
      EXPECT_NEAR(period(height, x) / 256.0, spacing, 0.15 * spacing);
      double change_across = 0.0, change_along = 0.0;
      for (uint32_t i = 1; i < 256; ++i) {
        for (uint32_t j = 1; j < 256; ++j) {
          const float dx = std::abs(height.at(i, j)[0] - height.at(i - 1, j)[0]);
          const float dy = std::abs(height.at(i, j)[0] - height.at(i, j - 1)[0]);
          change_across += x ? dx : dy;
          change_along += x ? dy : dx;
        }
      }
      EXPECT_LT(change_along, 0.3 * change_across);
    }
  }
}

TEST_P(Presets, HeightsAreBalancedAndUseTheirDepth) {
  const Surface surface = sheet();
  const auto field = along(surface, {1, 1, 0});
  const SynthesizedMaps maps = draw(surface, field, {GetParam(), 0.04, 0.004, 1}, 256);
  double sum = 0.0;
  float low = 0.0f, high = 0.0f, dark = 0.0f, bright = 1.0f;
  for (size_t i = 0; i < maps.height.pixels.size(); ++i) {
    const float h = maps.height.pixels[i];
    sum += h;
    low = std::min(low, h);
    high = std::max(high, h);
    dark = std::max(dark, maps.shading.pixels[i]);
    bright = std::min(bright, maps.shading.pixels[i]);
  }
  EXPECT_LT(std::abs(sum / static_cast<double>(maps.height.pixels.size())), 0.06);
  EXPECT_GT(high - low, 0.85f);
  EXPECT_LE(high - low, 1.05f);
  EXPECT_LE(dark, 0.5f);
  EXPECT_GT(dark, 0.35f);
  EXPECT_GE(bright, 0.0f);
  EXPECT_LT(bright, 0.02f);
}

// The map's slopes are the derivative of depth * height, T along +x and B along +y.
TEST_P(Presets, NormalsAreTheSlopesOfTheHeights) {
  const Surface surface = sheet();
  LayerField field = along(surface, {1, 0.3f, 0});
  for (size_t p = 0; p < field.strength.size(); ++p) {
    field.strength[p] = std::clamp(surface.point_positions[p].y * 1.5f - 0.2f, 0.0f, 1.0f);
  }
  const uint32_t size = 512;
  const double depth = 0.01;
  const SynthesizedMaps maps = draw(surface, field, {GetParam(), 0.1, depth, 1}, size);
  double error = 0.0, total = 0.0;
  for (uint32_t y = 1; y + 1 < size; ++y) {
    for (uint32_t x = 1; x + 1 < size; ++x) {
      const float *n = maps.normal.at(x, y), z = std::sqrt(1.0f - n[0] * n[0] - n[1] * n[1]);
      const double dx = depth * (maps.height.at(x + 1, y)[0] - maps.height.at(x - 1, y)[0]) * size / 2.0;
      const double dy = depth * (maps.height.at(x, y - 1)[0] - maps.height.at(x, y + 1)[0]) * size / 2.0;
      error += std::pow(-n[0] / z - dx, 2) + std::pow(-n[1] / z - dy, 2);
      total += dx * dx + dy * dy;
    }
  }
  EXPECT_GT(total, 0.0);
  EXPECT_LT(std::sqrt(error / total), 0.02);
}

TEST(Synthesis, MirroredChartsShowTheSameRelief) {
  const Surface surface = sheet();
  Surface mirrored = surface;
  for (glm::vec2& uv : mirrored.uvs) {
    uv.x = 1.0f - uv.x;
  }
  mirrored.tangents = tangents(mirrored.positions, mirrored.normals, mirrored.uvs, mirrored.triangles);
  const auto field = along(surface, {1, 0.5f, 0});
  const SynthesizedMaps a = draw(surface, field, skin(0.08), 128), b = draw(mirrored, field, skin(0.08), 128);
  for (uint32_t y = 0; y < 128; ++y) {
    for (uint32_t x = 0; x < 128; ++x) {
      ASSERT_NEAR(a.height.at(x, y)[0], b.height.at(127 - x, y)[0], 1e-4f);
      ASSERT_NEAR(a.normal.at(x, y)[0], -b.normal.at(127 - x, y)[0], 1e-3f);  // T runs the other way
      ASSERT_NEAR(a.normal.at(x, y)[1], b.normal.at(127 - x, y)[1], 1e-3f);
    }
  }
}

Surface cylinder(uint32_t shift) {
  return grid(
      64, 16,
      [](double u, double v) {
        const double angle = 2.0 * std::numbers::pi * u;
        return glm::vec3(std::cos(angle), 3.0 * v, -std::sin(angle));
      },
      [](double u, double) {
        const double angle = 2.0 * std::numbers::pi * u;
        return glm::vec3(std::cos(angle), 0.0, -std::sin(angle));
      },
      true, shift);
}

LayerField around(const Surface& surface) {
  LayerField field = along(surface, {0, 1, 0});
  for (size_t p = 0; p < field.direction.size(); ++p) {
    field.direction[p] =
        glm::normalize(glm::cross(surface.point_normals[p], field.direction[p]) + 0.4f * field.direction[p]);
  }
  return field;
}

TEST(Synthesis, ACylinderHasNoSeam) {
  const Surface surface = cylinder(0);
  const uint32_t size = 512;
  const SynthesizedMaps maps = draw(surface, around(surface), skin(0.37), size);
  float seam = 0.0f, anywhere = 0.0f;
  for (uint32_t y = 0; y < size; ++y) {
    seam = std::max(seam, std::abs(maps.height.at(0, y)[0] - maps.height.at(size - 1, y)[0]));
    for (uint32_t x = 1; x < size; ++x) {
      anywhere = std::max(anywhere, std::abs(maps.height.at(x, y)[0] - maps.height.at(x - 1, y)[0]));
    }
  }
  EXPECT_GT(seam, 0.0f);
  EXPECT_LE(seam, anywhere);
}

TEST(Synthesis, TheCutOfACylinderDoesNotShow) {
  const Surface a = cylinder(0), b = cylinder(24);
  const uint32_t size = 256;
  const SynthesizedMaps of_a = draw(a, around(a), skin(0.37), size),
                        of_b = draw(b, around(b), skin(0.37), size);
  for (uint32_t y = 0; y < size; ++y) {
    for (uint32_t x = 0; x < size; ++x) {
      const uint32_t moved = (x + 24 * size / 64) % size;
      ASSERT_NEAR(of_a.height.at(moved, y)[0], of_b.height.at(x, y)[0], 2e-3f) << x << ' ' << y;
    }
  }
}

TEST(Synthesis, TheSameAtAnySize) {
  const Surface surface = sheet();
  const auto field = along(surface, {0.2f, 1, 0});
  const Synthesis synthesis(surface, field, skin(0.08));
  const SynthesizedMaps small =
                            synthesis.draw(mapTexels(surface, chartsOf(surface, kPart), {512, 512}, 4), 2),
                        large =
                            synthesis.draw(mapTexels(surface, chartsOf(surface, kPart), {1024, 1024}, 4), 2);
  for (uint32_t y = 0; y < 512; ++y) {
    for (uint32_t x = 0; x < 512; ++x) {
      const float mean =
          0.25f * (large.height.at(2 * x, 2 * y)[0] + large.height.at(2 * x + 1, 2 * y)[0] +
                   large.height.at(2 * x, 2 * y + 1)[0] + large.height.at(2 * x + 1, 2 * y + 1)[0]);
      ASSERT_NEAR(small.height.at(x, y)[0], mean, 0.01f);
    }
  }
}

TEST(Synthesis, TheSameWithAnyTriangles) {
  const Surface coarse = sheet(2), fine = sheet(48);
  const SynthesizedMaps a = draw(coarse, along(coarse, {1, 1, 0}), skin(0.05), 256);
  const SynthesizedMaps b = draw(fine, along(fine, {1, 1, 0}), skin(0.05), 256);
  double difference = 0.0;
  for (size_t i = 0; i < a.height.pixels.size(); ++i) {
    difference += std::abs(a.height.pixels[i] - b.height.pixels[i]);
  }
  EXPECT_LT(difference / static_cast<double>(a.height.pixels.size()), 0.003);
}

TEST(Synthesis, TheSameOnAnyNumberOfThreads) {
  const Surface surface = sheet();
  const auto field = along(surface, {0.2f, 1, 0});
  const SynthesizedMaps one = draw(surface, field, skin(0.06), 256, 1),
                        three = draw(surface, field, skin(0.06), 256, 3);
  EXPECT_EQ(one.normal.pixels, three.normal.pixels);
  EXPECT_EQ(one.height.pixels, three.height.pixels);
  EXPECT_EQ(one.shading.pixels, three.shading.pixels);
}

TEST(Synthesis, ADirectionIsALine) {
  const Surface surface = sheet();
  LayerField field = along(surface, {0.2f, 1, 0});
  for (size_t p = 0; p < field.direction.size(); ++p) {
    const float turn = 2.0f * surface.point_positions[p].x;
    field.direction[p] = {std::sin(turn), std::cos(turn), 0.0f};
  }
  const SynthesizedMaps before = draw(surface, field, skin(0.06), 256);
  std::mt19937 random(5);
  for (glm::vec3& d : field.direction) {
    d = (random() & 1u) != 0 ? -d : d;
  }
  const SynthesizedMaps after = draw(surface, field, skin(0.06), 256);
  EXPECT_EQ(before.height.pixels, after.height.pixels);
  EXPECT_EQ(before.normal.pixels, after.normal.pixels);
}

TEST(Synthesis, SeedsDiffer) {
  const Surface surface = sheet();
  const auto field = along(surface, {1, 0, 0});
  EXPECT_NE(draw(surface, field, {Preset::kSkin, 0.06, 0.01, 1}, 64).height.pixels,
            draw(surface, field, {Preset::kSkin, 0.06, 0.01, 2}, 64).height.pixels);
}

TEST(Synthesis, FlatWhereTheLayerHasNoStrength) {
  const Surface surface = sheet();
  LayerField field = along(surface, {1, 0, 0});
  for (size_t p = 0; p < field.strength.size(); ++p) {
    field.strength[p] = surface.point_positions[p].x > 0.5f ? 1.0f : 0.0f;
  }
  const SynthesizedMaps half = draw(surface, field, skin(0.06), 256);
  const auto relief = [&](uint32_t begin, uint32_t end) {
    float most = 0.0f;
    for (uint32_t y = 0; y < 256; ++y) {
      for (uint32_t x = begin; x < end; ++x) {
        most = std::max({most, std::abs(half.height.at(x, y)[0]), std::abs(half.normal.at(x, y)[0]),
                         std::abs(half.normal.at(x, y)[1]), half.shading.at(x, y)[0]});
      }
    }
    return most;
  };
  EXPECT_EQ(relief(0, 127), 0.0f);
  EXPECT_GT(relief(160, 256), 0.3f);

  std::fill(field.strength.begin(), field.strength.end(), 0.0f);
  const SynthesizedMaps none = draw(surface, field, skin(0.06), 64);
  EXPECT_TRUE(
      std::all_of(none.normal.pixels.begin(), none.normal.pixels.end(), [](float v) { return v == 0.0f; }));
  EXPECT_TRUE(
      std::all_of(none.height.pixels.begin(), none.height.pixels.end(), [](float v) { return v == 0.0f; }));
}

TEST(Synthesis, SlopesStayWithinTheirLimit) {
  const Surface surface = sheet();
  const auto field = along(surface, {1, 0, 0});
  const SynthesizedMaps maps = draw(surface, field, {Preset::kSkin, 0.06, 0.1, 1}, 256);
  float steepest = 0.0f;
  for (size_t i = 0; i < maps.normal.pixels.size(); i += 2) {
    steepest = std::max(steepest, std::hypot(maps.normal.pixels[i], maps.normal.pixels[i + 1]));
  }
  EXPECT_NEAR(steepest / std::sqrt(1.0f - steepest * steepest), 1.2f, 1e-3f);
}

// A field with a singular point, without direction in places, over degenerate triangles.
TEST(Synthesis, WhateverTheFieldTheMapsAreFinite) {
  Surface surface = sheet();
  LayerField field = along(surface, {1, 0, 0});
  for (size_t p = 0; p < field.direction.size(); ++p) {
    const glm::vec3 from_centre = surface.point_positions[p] - glm::vec3(0.5f, 0.5f, 0.0f);
    field.direction[p] = glm::length(from_centre) > 0.1f ? glm::normalize(from_centre) : glm::vec3(0.0f);
    field.confidence[p] = std::min(glm::length(from_centre), 1.0f);
  }
  surface.triangles.emplace_back(0, 0, 5);
  surface.triangles.emplace_back(7, 7, 7);
  surface.parts[0].triangle_end += 2;
  const SynthesizedMaps maps = draw(surface, field, skin(0.03), 256);
  for (const Image* image : {&maps.normal, &maps.height, &maps.shading}) {
    for (const float v : image->pixels) {
      ASSERT_TRUE(std::isfinite(v));
      ASSERT_LE(std::abs(v), 1.0f);
    }
  }
}

TEST(Synthesis, RefusesWhatItCannotDo) {
  const Surface surface = sheet();
  LayerField field = along(surface, {1, 0, 0});
  EXPECT_THROW(Synthesis(surface, field, skin(1e-6)), std::length_error);
  // 300 slivers whose two edges from the first corner are 4000 spacings long have little area, and more cells
  // than 32 bits can number.
  const Surface ribbon = grid(
      300, 1, [](double u, double v) { return glm::vec3(0.001 * u, 4.0 * v, 0.0); },
      [](double, double) { return glm::vec3(0, 0, 1); });
  EXPECT_THROW(Synthesis(ribbon, along(ribbon, {1, 0, 0}), skin(0.001)), std::length_error);
  EXPECT_THROW(Synthesis(surface, field, {Preset::kSkin, 0.0, 0.1, 1}), std::invalid_argument);
  EXPECT_THROW(Synthesis(surface, field, {Preset::kSkin, NAN, 0.1, 1}), std::invalid_argument);
  field.strength.pop_back();
  EXPECT_THROW(Synthesis(surface, field, skin(0.1)), std::invalid_argument);
}

// Two sheets much closer to each other than a spacing, as an arm on a torso or a jacket on a shirt.
TEST(Kernels, SheetsThatAreNotJoinedDoNotTalk) {
  Surface surface = sheet();
  const Surface above = sheet();
  const auto vertices = static_cast<uint32_t>(surface.positions.size()),
             points = static_cast<uint32_t>(surface.point_positions.size());
  for (size_t p = 0; p < points; ++p) {
    surface.point_positions.push_back(above.point_positions[p] + glm::vec3(0, 0, 0.01f));
    surface.point_normals.push_back(above.point_normals[p]);
  }
  for (size_t v = 0; v < vertices; ++v) {
    surface.positions.push_back(above.positions[v] + glm::vec3(0, 0, 0.01f));
    surface.vertex_point.push_back(above.vertex_point[v] + points);
  }
  for (const glm::uvec3& t : above.triangles) {
    surface.triangles.push_back(t + vertices);
  }
  const Kernels kernels(surface, along(surface, {1, 0, 0}), 0.1, 1, {});
  size_t below = 0;
  for (uint32_t k = 0; k < kernels.size(); ++k) {
    below += kernels[k].position.z < 0.005f ? 1 : 0;
  }
  // Each sheet has its own, although they share the grid's cells.
  EXPECT_NEAR(static_cast<double>(below), static_cast<double>(kernels.size()) / 2.0, 20.0);
  for (uint32_t t = 0; t < surface.triangles.size(); ++t) {
    for (const uint32_t k : kernels.near(t, {0.3f, 0.3f})) {
      ASSERT_EQ(kernels[k].position.z < 0.005f, t < above.triangles.size());
    }
  }
}

TEST(Kernels, AreSpreadEvenly) {
  const Surface surface = sheet(3);
  const Kernels kernels(surface, along(surface, {1, 0, 0}), 0.05, 1, {});
  EXPECT_NEAR(static_cast<double>(kernels.size()), 1.0 / (0.6 * 0.6 * 0.05 * 0.05), 250.0);
  // Every place has its kernels: enough of them within reach, and those on the lists.
  for (uint32_t t = 0; t < surface.triangles.size(); ++t) {
    for (const glm::vec2 b : {glm::vec2(0.1f, 0.1f), glm::vec2(0.4f, 0.5f), glm::vec2(0.02f, 0.9f)}) {
      const glm::uvec3 p = surface.trianglePoints(t);
      const glm::vec3 x = surface.point_positions[p.x] * (1 - b.x - b.y) +
                          surface.point_positions[p.y] * b.x + surface.point_positions[p.z] * b.y;
      const auto near = kernels.near(t, b);
      size_t within = 0;
      for (uint32_t k = 0; k < kernels.size(); ++k) {
        if (glm::distance(kernels[k].position, x) < Kernels::kReach * 0.05f) {
          ++within;
          ASSERT_TRUE(std::binary_search(near.begin(), near.end(), k));
        }
      }
      EXPECT_GE(within, 4u);
    }
  }
}

// As a file that shows one sheet with many materials: work and memory do not grow with the copies.
TEST(Kernels, EqualTrianglesShareTheirLists) {
  Surface surface = sheet(3);
  const Kernels once(surface, along(surface, {1, 0, 0}), 0.05, 1, {});
  const std::vector<glm::uvec3> triangles = surface.triangles;
  surface.triangles.insert(surface.triangles.end(), triangles.begin(), triangles.end());
  const Kernels twice(surface, along(surface, {1, 0, 0}), 0.05, 1, {});
  ASSERT_EQ(twice.size(), once.size());
  for (uint32_t t = 0; t < triangles.size(); ++t) {
    const auto near = once.near(t, {0.3f, 0.3f}), first = twice.near(t, {0.3f, 0.3f}),
               copy = twice.near(t + static_cast<uint32_t>(triangles.size()), {0.3f, 0.3f});
    EXPECT_TRUE(std::ranges::equal(near, first));
    EXPECT_EQ(copy.data(), first.data());
    EXPECT_EQ(copy.size(), first.size());
  }
}

// With no irregularity the phases of a constant field are those of one plane wave.
TEST(Kernels, AgreeOnOneWaveWhereTheyCan) {
  const Surface surface = sheet();
  const glm::vec3 d = glm::normalize(glm::vec3(1, 2, 0));
  const Kernels kernels(surface, along(surface, d), 0.04, 1, {});
  for (uint32_t k = 1; k < kernels.size(); ++k) {
    const auto turns = [&](const Kernel& kernel) {
      return glm::dot(kernel.direction, d) * kernel.phase - glm::dot(d, kernel.position) / 0.04f;
    };
    const float difference = turns(kernels[k]) - turns(kernels[0]);
    ASSERT_NEAR(difference - std::round(difference), 0.0f, 0.01f);
  }
}

}  // namespace
}  // namespace furrow::pipeline
