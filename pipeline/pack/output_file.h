#pragma once

// Files that appear whole or not at all.

#include <cstddef>
#include <filesystem>
#include <span>

namespace furrow::pipeline {

// Writes and syncs a file without a name (O_TMPFILE), then renames it over `file`: readers see the old bytes
// or the new ones. Threads and processes may write the same file at once; the last one wins. A link stays,
// and what it leads to is replaced; a device or a pipe (/dev/null) is written to. Throws Error (kEnvironment)
// and leaves nothing behind.
//
// A process killed while it writes leaves nothing behind either, but for the moment between two system calls
// in which the finished bytes have a temporary name (NAME.PID-N.tmp), and on file systems without O_TMPFILE,
// where they have it from the start. Such a leftover goes when the same file is written the next time:
// writers hold a lock on theirs, which ends with them.
void writeFile(const std::filesystem::path& file, std::span<const std::byte> bytes);

}  // namespace furrow::pipeline
