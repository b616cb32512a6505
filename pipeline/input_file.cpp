#include "pipeline/input_file.h"

#include <algorithm>
#include <fstream>
#include <string>
#include <system_error>

#include "pipeline/error.h"

namespace furrow::pipeline {

std::filesystem::path namedFile(std::string_view name, const std::filesystem::path& folder) {
  std::error_code ignored;
  const std::filesystem::path given = folder / name;
  if (std::filesystem::is_regular_file(given, ignored)) return given;
  std::string portable(name);
  std::replace(portable.begin(), portable.end(), '\\', '/');
  return folder / portable;
}

std::vector<uint8_t> readBytes(const std::filesystem::path& file) {
  const std::string name = file.string();
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) throw Error(Exit::kBadData, name, "no such file", "check the path");
  if (std::filesystem::is_directory(status))
    throw Error(Exit::kBadData, name, "is a directory", "name a file in it");
  if (!std::filesystem::is_regular_file(status))
    throw Error(Exit::kBadData, name, "is not a regular file", "copy it into one");
  const uintmax_t size = std::filesystem::file_size(file, error);
  std::ifstream in(file, std::ios::binary);
  if (error || !in) throw Error(Exit::kEnvironment, name, "cannot be opened", "check its permissions");
  std::vector<uint8_t> bytes(static_cast<size_t>(size));
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (static_cast<uintmax_t>(in.gcount()) != size)
    throw Error(Exit::kEnvironment, name, "cannot be read to its end", "check the disk");
  return bytes;
}

}  // namespace furrow::pipeline
