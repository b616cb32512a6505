#pragma once

// What a runtime call came to. No exception crosses the runtime's interface.

#include <cstddef>
#include <cstdint>

namespace furrow {

enum class StatusCode : int32_t {
  kOk = 0,
  kBadData = 1,             // the bytes are not a sound furrow asset
  kUnsupportedVersion = 2,  // a sound asset of a format this build does not read
  kUnsupportedFeature = 3,  // sound, but needs a part this build was made without (Draco)
  kOutOfMemory = 4,
  kInvalidArgument = 5,  // a span is too short, an index too large, a number not finite
  kUnavailable = 6,      // a forced tier that this machine does not have
};

// `message` is English without a line break, says what is wrong and with what, and is empty when code is kOk.
struct Status {
  static constexpr size_t kMessageSize = 192;

  StatusCode code = StatusCode::kOk;
  char message[kMessageSize] = {};

  bool ok() const { return code == StatusCode::kOk; }
  static Status error(StatusCode code, const char* format, ...);
};

}  // namespace furrow
