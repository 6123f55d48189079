#include "io/stop.hpp"

#include <utility>

namespace io {
namespace {

thread_local const std::function<bool()>* asked = nullptr;

}  // namespace

bool stop_asked() { return asked != nullptr && (*asked)(); }

void stop_if_asked() {
  if (stop_asked()) throw Stopped();
}

StopAsker::StopAsker(std::function<bool()> asker) : asker_(std::move(asker)), before_(std::exchange(asked, &asker_)) {}
StopAsker::~StopAsker() { asked = before_; }

void forget_asker() { asked = nullptr; }

}  // namespace io
