#pragma once

// Bytes by a number of 128 bits, for what is kept under its content.

#include <cstddef>
#include <span>
#include <string>

namespace furrow::pipeline {

std::string contentKey(std::span<const std::byte> bytes);

}  // namespace furrow::pipeline
