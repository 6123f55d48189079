// A chip that is held, or stands still: its pins.
#include "c40/engine.hpp"

namespace c40 {

void Engine::watch_pins(PinListener* listener, unsigned outputs, unsigned inputs) {
  pins_.watch(listener, outputs, inputs);
  peripherals_.pins_changed();
}

void Engine::stand_until(Cycles cycle) {
  touch();
  pass(Cause::halted, cycle);
  if (pins_.watched() && !state_.held) peripherals_.advance_to(state_.cycle);
}

// One that is held drives nothing. What its timers would have done meanwhile nobody has seen.
void Engine::hold(bool held) {
  touch();
  if (pins_.watched() && held != state_.held) peripherals_.advance_to(state_.cycle);
  state_.held = held;
  peripherals_.pins_changed();
}

}  // namespace c40
