#pragma once

// Line fields on a surface, smoothed: from what speaks for a direction here and there to one everywhere.

#include <complex>
#include <vector>

#include "pipeline/bake/intrinsic_delaunay.h"
#include "pipeline/bake/multigrid.h"
#include "pipeline/bake/squeeze.h"
#include "pipeline/bake/surface.h"

namespace furrow::pipeline {

struct DirectionField {
  std::vector<glm::vec3> direction;  // a point, unit; zero where undefined
  std::vector<float> confidence;     // a point, [0, 1]
};

// A line in a frame is a complex number of twice its angle, so that d and -d are one; its length, up to 1, is
// how sure it is. With evidence m of weight p, solve() minimises over the covered triangles
//
//     integral |grad z|^2 + |z|^2 / R^2   +   sum of p |z - m|^2
//
// on the connection Laplacian [Knoeppel et al. 2013, n = 2] with cotangent and area weights, so that the
// field is one of the surface and not of its triangulation; evidence that contradicts itself cancels to a
// short z.
class LineField {
 public:
  using Complex = std::complex<double>;

  LineField(const Surface& surface, const std::vector<bool>& covered);

  double size() const { return size_; }    // square root of the covered area; 0: nothing is covered
  double reach() const { return reach_; }  // R: how far from the evidence z falls to 1/e

  // Evidence at a place of a covered triangle. `line` is in its triangleFrame().
  void add(size_t triangle, glm::dvec3 barycentric, Complex line, double weight);

  // Confidence is |z|. Where nothing is known the direction is +Y (or any, where that is the normal) with
  // confidence 0; at points of no covered triangle it is zero. Uses up the evidence.
  DirectionField solve() &&;

 private:
  struct Frame {
    glm::dvec3 x, y, normal;
  };
  static Frame frameOf(glm::dvec3 normal);
  static glm::dvec3 turned(glm::dvec3 v, glm::dvec3 from_normal, glm::dvec3 to_normal);
  std::vector<IntrinsicTriangle> intrinsicTriangles() const;
  Equations equations() const;

  const Surface& surface_;
  const std::vector<bool>& covered_;
  std::vector<int> unknown_;     // a point, -1: not covered
  std::vector<uint32_t> point_;  // an unknown
  std::vector<double> area_;
  std::vector<Complex> pull_;        // sum of weight * line
  std::vector<double> pull_weight_;  // sum of weight
  double size_ = 0.0, reach_ = 0.0;
};

}  // namespace furrow::pipeline
