#include "pipeline/cook/cook_memory.h"

#include "pipeline/cook/kept_results.h"

namespace furrow::pipeline {

CookMemory::CookMemory() : kept_(std::make_unique<KeptResults>()) {}
CookMemory::~CookMemory() = default;

void CookMemory::forgetScene() {
  kept_->forgetScene();
}

void KeptResults::forgetScene() {
  patterns.clear();
  layers.clear();
  ground.reset();
  ground_key.clear();
}

}  // namespace furrow::pipeline
