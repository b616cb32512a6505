#pragma once

// What cooks of one scene keep for the next one: the editor cooks after every change of a recipe, first with
// small maps and then with large ones. The asset is the same, byte by byte, with or without it.

#include <memory>

namespace furrow::pipeline {

struct KeptResults;

// Of one cook at a time.
class CookMemory {
 public:
  CookMemory();
  ~CookMemory();

  void forgetScene();  // before another one is cooked, or the same file once it has changed

  KeptResults& kept() { return *kept_; }  // of the cook alone

 private:
  std::unique_ptr<KeptResults> kept_;
};

}  // namespace furrow::pipeline
