#include "furrow/bind.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "furrow/place_hash.h"
#include "near_cells.h"

namespace furrow {
namespace {

// While triangles are looked at, a vertex whose place has several points holds the first of them and one of
// these marks.
constexpr uint32_t kOpen = 0x80000000u, kContradicted = 0xc0000000u, kMarks = 0xc0000000u;
constexpr uint32_t kMostPoints = 1u << 30;
constexpr uint32_t kMostTests = 1024;  // a vertex; more than that is no search for a neighbour

Status invalid(const char* what) {
  return Status::error(StatusCode::kInvalidArgument, "bind: %s", what);
}

bool finite(const Affine& affine) {
  return std::all_of(std::begin(affine.m), std::end(affine.m), [](float x) { return std::isfinite(x); });
}

// Of the vertex that stands for the point, in root space and the bind pose.
Float3 positionOf(const AssetView& asset, uint32_t point) {
  const uint32_t vertex = asset.point_vertex[point];
  const auto part = std::upper_bound(asset.parts.begin(), asset.parts.end(), vertex,
                                     [](uint32_t v, const Part& each) { return v < each.vertex_end; });
  return transformed(part->rest, asset.positions[vertex]);
}

double distance(Float3 p, Float3 q) {
  const double x = double{p.x} - q.x, y = double{p.y} - q.y, z = double{p.z} - q.z;
  return std::sqrt((x * x + y * y) + z * z);
}

size_t tableSize(const AssetView& asset) {
  return std::bit_ceil(size_t{asset.pointCount()} * 2);
}

// The points by cells of a grid, as lists.
class PointGrid {
 public:
  PointGrid(const AssetView& asset, float tolerance, std::span<uint32_t> places, std::span<uint32_t> scratch)
      : asset_(asset),
        places_(places),
        reach_(double{tolerance} + asset.position_error),
        cells_(reach_, 2.0 * reach_),
        heads_(scratch.first(tableSize(asset))),
        next_(scratch.subspan(heads_.size(), asset.pointCount())) {
    std::fill(heads_.begin(), heads_.end(), kAbsent);
    for (uint32_t point = 0; point < asset.pointCount(); ++point) {
      const Float3 p = positionOf(asset, point);
      uint32_t& head = heads_[cells_.around(p.x, p.y, p.z).cells[0] & (heads_.size() - 1)];
      next_[point] = head;
      head = point;
    }
  }

  // The place nearest to p, as its first point, or kUnmatched or kAmbiguous.
  uint32_t find(Float3 p) const {
    uint32_t nearest = kUnmatched, tests = 0;
    double best = reach_, second = INFINITY;  // second: of another place
    const NearCells::Hashes near = cells_.around(p.x, p.y, p.z);
    for (uint32_t c = 0; c < near.count; ++c)
      for (uint32_t point = heads_[near.cells[c] & (heads_.size() - 1)]; point != kAbsent;
           point = next_[point]) {
        if (++tests > kMostTests) return kAmbiguous;
        const double away = distance(p, positionOf(asset_, point));
        if (!(away <= reach_)) continue;
        const uint32_t place = places_[point];
        if (away <= best) {
          if (place != nearest && nearest != kUnmatched) second = best;
          best = away;
          nearest = place;
        } else if (place != nearest) {
          second = std::min(second, away);
        }
      }
    return second - best <= 2.0 * asset_.position_error ? kAmbiguous : nearest;
  }

 private:
  const AssetView& asset_;
  std::span<const uint32_t> places_;
  double reach_;
  NearCells cells_;
  std::span<uint32_t> heads_, next_;
};

class Binding {
 public:
  explicit Binding(const BindJob& job)
      : job_(job), asset_(*job.asset), places_(job.scratch.first(asset_.pointCount())) {
    std::iota(places_.begin(), places_.end(), 0);
    for (size_t i = 0; i < asset_.place_points.size(); i += 2)
      for (uint32_t k = 0; k < asset_.place_points[i + 1]; ++k)
        places_[asset_.place_points[i] + k] = asset_.place_points[i];
  }

  BindCounts run() {
    findPlaces();
    // What one sweep tells apart may help its neighbours in the next: a patch of surfaces that touch is told
    // apart from its border inwards.
    while (tellApart()) {
    }
    BindCounts counts;
    for (uint32_t& point : job_.points.first(job_.positions.size())) {
      if (point != kUnmatched && (point & kMarks) != 0) point = kAmbiguous;
      ++(point == kUnmatched ? counts.unmatched : point == kAmbiguous ? counts.ambiguous : counts.matched);
    }
    return counts;
  }

 private:
  void findPlaces() {
    PlaceHash hash;
    const bool sound = hash.open(asset_.place_hash).ok();
    const auto find = [&](Float3 p) {
      const auto slot = sound ? hash.find(p) : std::nullopt;
      if (!slot) return kUnmatched;
      const uint32_t point = asset_.place_points[2 * size_t{*slot}];
      return distance(p, positionOf(asset_, point)) <= asset_.place_error ? point : kUnmatched;
    };
    const auto setAll = [&](auto search) {
      for (size_t v = 0; v < job_.positions.size(); ++v) {
        const uint32_t place = search(transformed(job_.to_root, job_.positions[v]));
        job_.points[v] = place < kMostPoints && holdsSeveral(place) ? place | kOpen : place;
      }
    };
    if (!(job_.tolerance > 0.0f)) return setAll(find);
    const PointGrid grid(asset_, job_.tolerance, places_, job_.scratch.subspan(places_.size()));
    setAll([&](Float3 p) {
      const uint32_t place = find(p);
      return place != kUnmatched ? place : grid.find(p);
    });
  }

  bool holdsSeveral(uint32_t place) const {
    return place + 1 < places_.size() && places_[place + 1] == place;
  }

  bool tellApart() {
    bool changed = false;
    for (size_t i = 0; i + 2 < job_.indices.size(); i += 3)
      for (size_t c = 0; c < 3; ++c) {
        uint32_t& point = job_.points[job_.indices[i + c]];
        if (point >= kAmbiguous) continue;
        const uint32_t place = (point & kMarks) != 0 ? point & ~kMarks : places_[point];
        if ((point & kMarks) == kContradicted || !holdsSeveral(place)) continue;
        const uint32_t one = candidate(place, job_.points[job_.indices[i + (c + 1) % 3]],
                                       job_.points[job_.indices[i + (c + 2) % 3]]);
        if (one == kAbsent || one == point) continue;
        point = (point & kMarks) == kOpen ? one : place | kContradicted;
        changed = true;
      }
    return changed;
  }

  // The only point of the place that has a triangle to a and b, or kAbsent.
  uint32_t candidate(uint32_t place, uint32_t a, uint32_t b) const {
    uint32_t found = kAbsent;
    for (uint32_t point = place; point < places_.size() && places_[point] == place; ++point) {
      if (!hasTriangle(point, a, b)) continue;
      if (found != kAbsent) return kAbsent;
      found = point;
    }
    return found;
  }

  bool hasTriangle(uint32_t point, uint32_t a, uint32_t b) const {
    for (uint32_t i = asset_.ring_offsets[point]; i < asset_.ring_offsets[point + 1]; ++i) {
      const uint32_t* corners = &asset_.surface_indices[3 * size_t{asset_.ring_triangles[i]}];
      uint32_t others[3], count = 0;
      for (int c = 0; c < 3; ++c)
        if (const uint32_t other = asset_.vertex_point[corners[c]]; other != point) others[count++] = other;
      if (count == 2 &&
          ((fits(others[0], a) && fits(others[1], b)) || (fits(others[0], b) && fits(others[1], a))))
        return true;
    }
    return false;
  }

  // Whether the asset's point may be the vertex that is bound, or still open, as `bound` says.
  bool fits(uint32_t point, uint32_t bound) const {
    if (bound >= kAmbiguous) return false;
    return (bound & kMarks) != 0 ? places_[point] == (bound & ~kMarks) : point == bound;
  }

  const BindJob& job_;
  const AssetView& asset_;
  std::span<uint32_t> places_;  // a point: the first point of its place
};

}  // namespace

size_t BindJob::scratchSize() const {
  return asset->pointCount() + (tolerance > 0.0f ? tableSize(*asset) + asset->pointCount() : 0);
}

Status BindJob::validate() const {
  if (!asset) return invalid("no asset");
  if (asset->pointCount() >= kMostPoints) return invalid("the asset has more than 2^30 points");
  if (!(tolerance >= 0.0f) || !std::isfinite(tolerance)) return invalid("the tolerance is not a length");
  if (!finite(to_root)) return invalid("the transform is not finite");
  if (points.size() < positions.size()) return invalid("fewer points than positions");
  if (scratch.size() < scratchSize()) return invalid("the scratch memory is too small");
  if (indices.size() % 3 != 0) return invalid("the indices are no triangles");
  for (uint32_t index : indices)
    if (index >= positions.size()) return invalid("an index is out of range");
  PlaceHash hash;
  if (Status status = hash.open(asset->place_hash); !status.ok()) return status;
  if (asset->place_points.size() != 2 * size_t{hash.placeCount()})
    return Status::error(StatusCode::kBadData, "bind: the asset's places and its hash do not fit");
  return {};
}

BindCounts BindJob::run() const {
  return Binding(*this).run();
}

}  // namespace furrow
