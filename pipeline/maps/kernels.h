#pragma once

// The waves that a synthesised wrinkle pattern is made of: phasor kernels on the surface (Tricard et al.
// 2019, Procedural Phasor Noise), whose phases agree with their neighbours', so that the ridges are evenly
// spaced and branch only where the direction field makes them (the aim of Knoeppel et al. 2015, Stripe
// Patterns on Surfaces).

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "pipeline/bake/surface.h"

namespace furrow::pipeline {

// Around `position` the pattern is cos(2 pi (phase + dot(direction, x - position) / spacing)).
struct Kernel {
  glm::vec3 position{0.0f};
  glm::vec3 normal{0.0f};     // unit
  glm::vec3 direction{0.0f};  // unit, tangent; negating it and the phase changes nothing
  float phase = 0.0f;         // turns
  float depth = 1.0f;         // [0, 1]: of the line here
  float minor = 0.0f;         // [0, 1]: of the minor line half way to the next
};

// How far the pattern departs from even lines; lengths are in spacings.
struct Irregularity {
  double sway = 0.0;         // how far lines wander from their even place
  double sway_length = 1.0;  // over which length
  double line = 0.0;         // phase of the lines, in turns: 0 the ridges, 0.5 the valleys
  uint32_t line_steps = 0;   // how long a line keeps its depth: with the root of it
  double shallowest = 1.0;   // depth of the weakest lines, [0, 1]
  double ending = 0.0;       // part of the lines' length that is at its shallowest, [0, 1)
  double minor = 0.0;        // part of the length that has a minor line beside it, [0, 1]
};

class Kernels {
 public:
  // Kernels about 0.6 spacings apart wherever the layer has strength. They are set by the surface and the
  // seed, not by its triangles. Throws std::length_error if the spacing is so small that the surface would
  // need millions of them.
  Kernels(const Surface& surface, const LayerField& field, double spacing, uint32_t seed,
          const Irregularity& irregularity);

  // A kernel has no influence further away, nor where a walk along the surface within that ball does not
  // lead.
  static constexpr double kReach = 1.6;  // spacings

  // The kernels that may reach a place on the surface, ascending.
  std::span<const uint32_t> near(uint32_t triangle, glm::vec2 barycentric) const;

  const Kernel& operator[](uint32_t k) const { return kernels_[k]; }
  size_t size() const { return kernels_.size(); }

 private:
  // A triangle is cut into columns x rows equal parallelograms (half of them outside), each with a list of
  // kernels; neighbouring triangles that are far smaller share one.
  struct Grid {
    uint32_t begin = 0;
    uint32_t columns = 0, rows = 0;  // 0: the layer does not reach the triangle
  };
  uint32_t cell(uint32_t triangle, glm::vec2 barycentric) const;

  std::vector<Kernel> kernels_;
  std::vector<Grid> grids_;  // a triangle
  std::vector<uint32_t> offsets_, lists_;
};

// The mean of three lines (d and -d are the same) with weights, in the plane of `normal`: unit, with an
// arbitrary sign; any tangent where the lines cancel.
glm::vec3 meanLine(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& weights,
                   const glm::vec3& normal);

}  // namespace furrow::pipeline
