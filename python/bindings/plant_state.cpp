// A dock's snapshot for Python: copied, and as bytes for builds of the same layout alone.
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "plant/state.hpp"
#include "python/bindings/plant.hpp"

using namespace plant;

namespace {

// All members in their order. A member that is added to DockState has to be added here: else this is no C++.
template <class State, class Do>
void each_member(State& state, Do&& act) {
  auto& [latch, crane, inputs, stretch, shadow, code, underway, shadow_enable, enabled, updated, stopped, failed_drives, protection,
         stuck_encoders, stuck_sways, stuck_count, spreader_command, lock, lock_done, carried, grip, landing, handover, sway_shown,
         sway_sampled, instruments, containers, agvs, scans, row, modes, faulted, delivered] = state;
  (act(latch), act(crane), act(inputs), act(stretch), act(shadow), act(code), act(underway), act(shadow_enable), act(enabled), act(updated),
   act(stopped), act(failed_drives), act(protection), act(stuck_encoders), act(stuck_sways), act(stuck_count), act(spreader_command),
   act(lock), act(lock_done), act(carried), act(grip), act(landing), act(handover), act(sway_shown), act(sway_sampled), act(instruments),
   act(containers), act(agvs), act(scans), act(row), act(modes), act(faulted), act(delivered));
}

class Writer {
 public:
  template <class T>
  void operator()(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    text_.append(reinterpret_cast<const char*>(&value), sizeof value);  // NOLINT: bytes of a plain value
  }
  template <class T>
  void operator()(const std::vector<T>& all) {
    (*this)(all.size());
    for (const T& value : all) (*this)(value);
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

class Reader {
 public:
  explicit Reader(std::string_view text) : rest_(text), size_(text.size()) {}

  template <class T>
  void operator()(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (rest_.size() < sizeof value) refuse();
    std::memcpy(&value, rest_.data(), sizeof value);
    rest_.remove_prefix(sizeof value);
  }
  template <class T>
  void operator()(std::vector<T>& all) {
    std::size_t size = 0;
    (*this)(size);
    if (size > rest_.size() / sizeof(T)) refuse();
    all.resize(size);
    for (T& value : all) (*this)(value);
  }
  void end() const {
    if (!rest_.empty()) refuse();
  }

 private:
  [[noreturn]] void refuse() const {
    throw py::value_error("these " + std::to_string(size_) + " bytes are no snapshot of this version; one that this build has pickled is expected");
  }

  std::string_view rest_;
  std::size_t size_;
};

py::bytes bytes_of(const DockState& state) {
  Writer writer;
  each_member(state, writer);
  return writer.text();
}

DockState state_of(const py::bytes& bytes) {
  DockState state;
  Reader reader{std::string_view(bytes)};
  each_member(state, reader);
  reader.end();
  return state;
}

}  // namespace

void bind_plant_state(py::module_& m) {
  py::class_<DockState, std::shared_ptr<DockState>>(m, "DockState", "A dock's complete state at a latch; opaque.")
      .def("__copy__", [](const DockState& s) { return s; })
      .def("__deepcopy__", [](const DockState& s, const py::dict&) { return s; })
      .def(py::pickle(&bytes_of, &state_of));
}
