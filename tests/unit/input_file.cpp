// How large an input may be.
#include "io/input_file.hpp"

#include <doctest/doctest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

TEST_CASE("an input of the greatest size is read whole; one byte more is refused") {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("cmrc_input_" + std::to_string(::getpid()));
  const std::string text(1000, 'x');
  std::ofstream(path) << text;
  CHECK(io::read_input(path, 1000).text == text);
  CHECK(io::read_input(path, 1000).problem.empty());
  CHECK(io::read_input(path, 999).text.empty());
  CHECK(io::read_input(path, 999).problem.starts_with("is larger than"));
  std::filesystem::remove(path);
}
