#pragma once

// The face shapes that ARKit names and their many spellings, and which of them crease which part of a face.

#include <string>
#include <utility>
#include <vector>

namespace furrow::pipeline {

// Indices of the names that mean `shape`: those that are equal to it; else those that differ in case, in
// separators, in a prefix before a dot or colon, or in writing Left and Right as L and R; else, for a shape
// without a side, those of its two sides.
std::vector<size_t> matchShape(const std::vector<std::string>& names, const std::string& shape);

// Names of the tables of drivers, such as "arkit:forehead": a region of the face, whole or its "Left" or
// "Right".
std::vector<std::string> driverTables();

// Shapes and gains of a table. Every shape of a region at 1 adds up to 1 or more.
std::vector<std::pair<std::string, double>> driverTable(const std::string& name);

}  // namespace furrow::pipeline
