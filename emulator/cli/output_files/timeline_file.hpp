#pragma once
// The file of --perfetto, compressed if its name ends in .gz.
#include <optional>
#include <ostream>
#include <string>

#include "io/gzip_stream.hpp"
#include "io/output_file.hpp"

namespace cli {

class TimelineFile {
 public:
  /// \throws io::CannotOpen
  explicit TimelineFile(const std::string& name) : file_(name) {
    if (name.ends_with(".gz")) packed_.emplace(file_.stream());
  }
  std::ostream& stream() { return packed_ ? static_cast<std::ostream&>(*packed_) : file_.stream(); }
  void finish() {
    if (packed_) packed_->finish();
    file_.commit_or_note();
  }

 private:
  io::OutputFile file_;
  std::optional<io::GzipStream> packed_;
};

}  // namespace cli
