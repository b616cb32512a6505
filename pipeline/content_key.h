#pragma once

// Bytes by a number of 128 bits, for what is kept under its content: 32 digits. That of a list is that of its
// items' keys one behind the other.

#include <cstddef>
#include <span>
#include <string>

namespace furrow::pipeline {

std::string contentKey(std::span<const std::byte> bytes);
std::string contentKey(const std::string& text);

}  // namespace furrow::pipeline
