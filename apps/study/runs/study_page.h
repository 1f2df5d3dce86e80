// The page of a study: one self-contained HTML file with its charts, tables and differences.
#pragma once

#include <string>

namespace cosplat {

// Writes <folder>/index.html from the lines in it; with `charts`, each chart as a file of that
// folder, too. Throws Error when there is no line.
void WriteStudyPage(const std::string& folder, const std::string& charts);

}  // namespace cosplat
