/// Files that several subcommands write.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace edge_mcl {

/// @throws InputError when it cannot be written; likewise below.
void writeJson(const std::string& file, const nlohmann::json& content);
void makeDirectory(const std::string& directory);

}  // namespace edge_mcl
