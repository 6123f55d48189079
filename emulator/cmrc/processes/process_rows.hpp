#pragma once
// Reading rows of [[processes]] and [[subprocesses]]; for the files that know TOML.
#include <toml++/toml.h>

#include <string>

#include "cmrc/processes/process_table.hpp"

namespace cmrc {

/// Lays the rows over those of the same number in `table`. \param name of the file \throws ConfigError
void read_processes(const toml::node& rows, const std::string& name, ProcessTable& table);
void read_subprocesses(const toml::node& rows, const std::string& name, ProcessTable& table);

}  // namespace cmrc
