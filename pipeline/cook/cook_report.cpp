#include "pipeline/cook/cook_report.h"

#include <nlohmann/json.hpp>

#include "pipeline/maps/encode.h"

namespace furrow::pipeline {

std::string reportText(const CookReport& report, const std::string& asset) {
  using json = nlohmann::ordered_json;
  json stages = json::array();
  double seconds = 0.0;
  for (const CookStage& stage : report.stages) {
    stages.push_back({{"name", stage.name}, {"seconds", stage.seconds}});
    seconds += stage.seconds;
  }
  json layers = json::array();
  for (const LayerReport& layer : report.layers) {
    json& out = layers.emplace_back(json{{"name", layer.name},
                                         {"lambda", layer.response.lambda},
                                         {"beta", layer.response.beta},
                                         {"lowConfidence", layer.low_confidence}});
    if (layer.fit)
      out["fit"] = {
          {"target", layer.fit->target}, {"alpha", layer.fit->alpha}, {"weight", layer.fit->weight}};
  }
  json textures = json::array();
  for (const TextureReport& t : report.textures)
    textures.push_back({{"set", t.set},
                        {"format", textureFormatName(t.format)},
                        {"width", t.width},
                        {"height", t.height},
                        {"slices", t.slices},
                        {"bytes", t.bytes},
                        {"rmsError", t.rms_error},
                        {"largestError", t.largest_error},
                        {"preview", t.own}});
  const json out = {{"asset", asset},
                    {"bytes", report.bytes},
                    {"vertices", report.vertices},
                    {"triangles", report.triangles},
                    {"polygons", report.polygons},
                    {"degenerateTriangles", report.topology.degenerate_triangles},
                    {"duplicateTriangles", report.topology.duplicate_triangles},
                    {"nonManifoldEdges", report.topology.non_manifold_edges},
                    {"borderEdges", report.topology.border_edges},
                    {"isolatedVertices", report.topology.isolated_vertices},
                    {"places", report.places},
                    {"points", report.points},
                    {"weldTolerance", report.weld_tolerance},
                    {"morphTargets", report.morphs},
                    {"clips", report.clips},
                    {"positionError", report.position_error},
                    {"morphError", report.morph_error},
                    {"diagonal", report.diagonal},
                    {"layers", layers},
                    {"textures", textures},
                    {"seconds", seconds},
                    {"stages", stages},
                    {"warnings", report.warnings}};
  // A name in a file need not be UTF-8.
  return out.dump(2, ' ', false, json::error_handler_t::replace) + '\n';
}

}  // namespace furrow::pipeline
