#include "edge_mcl/core/import/obj_names.h"

#include <algorithm>

namespace edge_mcl {

bool joinObjectNames(std::string* text) {
  const auto isBlank = [](char c) { return c == ' ' || c == '\t'; };
  bool changed = false;
  for (size_t line = 0; line < text->size();) {
    const size_t end = std::min(text->find('\n', line), text->size());
    size_t at = line;
    while (at < end && isBlank((*text)[at])) ++at;
    if (at + 1 < end && (*text)[at] == 'o' && isBlank((*text)[at + 1])) {
      size_t first = at + 1, last = end;
      while (first < last && isBlank((*text)[first])) ++first;
      while (last > first && (isBlank((*text)[last - 1]) || (*text)[last - 1] == '\r')) --last;
      for (size_t i = first; i < last; ++i)
        if (isBlank((*text)[i])) {
          (*text)[i] = '_';
          changed = true;
        }
    }
    line = end + 1;
  }
  return changed;
}

}  // namespace edge_mcl
