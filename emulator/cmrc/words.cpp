#include "cmrc/words.hpp"

#include <utility>

namespace cmrc {

Words::Words(const std::function<Word(std::string_view)>& symbol) {
  static constexpr std::pair<std::string_view, Word Words::*> table[] = {
      {"LIST_WORK_POINTER", &Words::list_work_pointer}, {"LIST_REFRESH", &Words::list_refresh},
      {"BLOCK_POOL", &Words::block_pool}, {"BLOCK_COUNT", &Words::block_count}, {"BLOCK_WORDS", &Words::block_words},
      {"TB_X", &Words::x}, {"TB_Y", &Words::y}, {"TB_T", &Words::t}, {"TB_FLAG", &Words::flag},
      {"TB_J", &Words::importance}, {"TB_LINK", &Words::link}, {"TB_KIND", &Words::kind}, {"TB_AREA", &Words::area},
      {"TB_TICK", &Words::tick}, {"TB_ARGUMENT", &Words::argument}, {"TB_OWNER", &Words::owner},
      {"TB_GENERATION", &Words::generation}, {"TB_RESULT", &Words::result}, {"TB_NOTIFY", &Words::notify}, {"TB_SLICE", &Words::slice}, {"TB_ALIVE", &Words::alive}, {"SLICE_CYCLES", &Words::slice_cycles},
      {"MUST_CONTINUE", &Words::must_continue},
      {"FLAG_WAITING", &Words::flag_waiting}, {"FLAG_TAKEN", &Words::flag_taken}, {"FLAG_DONE", &Words::flag_done},
      {"KIND_ERROR", &Words::kind_error}, {"KIND_TRAJECTORY_CRANE", &Words::kind_trajectory_crane},
      {"KIND_TRAJECTORY_AGV", &Words::kind_trajectory_agv}, {"KIND_INVERSE_CRANE", &Words::kind_inverse_crane},
      {"KIND_INVERSE_AGV", &Words::kind_inverse_agv}, {"KIND_TORQUE", &Words::kind_torque},
      {"KIND_PID", &Words::kind_pid}, {"KIND_IDENTIFY", &Words::kind_identify},
      {"KIND_GRAB_PATH", &Words::kind_grab_path}, {"KIND_HOME_CRANE", &Words::kind_home_crane},
      {"KIND_HOME_AGV", &Words::kind_home_agv}, {"KIND_AVOIDANCE", &Words::kind_avoidance},
      {"KIND_COUNT", &Words::kind_count}, {"KIND_USER", &Words::kind_user}, {"US_BASE", &Words::us_base},
      {"US_WORDS", &Words::us_words}, {"MUST_PROCESS", &Words::must_process}, {"MAY_PROCESS", &Words::may_process},
      {"MUST_SUBPROCESS", &Words::must_subprocess}, {"MUST_TRAJECTORY", &Words::must_trajectory}, {"MUST_INVERSE", &Words::must_inverse},
      {"RESULT_END_OF_LEG", &Words::end_of_leg}, {"PID_LANDED", &Words::pid_landed},
      {"PID_LOCKED", &Words::pid_locked}, {"PID_OPEN", &Words::pid_open}, {"PID_STARVED", &Words::pid_starved},
      {"PID_SETTLED", &Words::pid_settled}, {"PID_RAMP_DONE", &Words::pid_ramp_done}, {"PID_BEGAN", &Words::pid_began},
      {"PID_STEADY", &Words::pid_steady}, {"PID_WINDY", &Words::pid_windy}, {"TORQUE_WIND", &Words::torque_wind}, {"TORQUE_LOAD", &Words::torque_load},
      {"PIDE_FAULT", &Words::pide_fault}, {"PIDE_LATE", &Words::pide_late}, {"PIDE_ENCODER", &Words::pide_encoder},
      {"PIDE_FOLLOWING", &Words::pide_following}, {"PIDE_SWAY", &Words::pide_sway}, {"PIDE_RESTS", &Words::pide_rests}, {"PIDE_TRIP", &Words::pide_trip},
      {"ERROR_OF", &Words::error_of},
      {"ERROR_TRIES", &Words::error_tries}, {"ERROR_LOWERING", &Words::error_lowering}, {"ERROR_SECOND", &Words::error_second},
      {"RESPOND_PLACE", &Words::respond_place}, {"CR_STOPPED", &Words::cr_stopped}, {"CR_SWAY_SENSOR", &Words::cr_sway_sensor},
      {"CR_PATH", &Words::cr_path}, {"CR_CONTROL", &Words::cr_control}, {"CR_CONTROL_BLOCK", &Words::cr_control_block}, {"PC_SWAY", &Words::pc_sway}, {"CR_SPEED", &Words::cr_speed},
      {"SEMAPHORE", &Words::semaphore}, {"SEMAPHORE_OWNER", &Words::semaphore_owner}, {"SEMAPHORE_HELD", &Words::semaphore_held},
      {"SEMAPHORE_LIST", &Words::semaphore_list}, {"DOORBELL_RING", &Words::doorbell_ring},
      {"DOORBELL_IDLE", &Words::doorbell_idle}, {"DOORBELL_BUSY", &Words::doorbell_busy}, {"FENCE_MASK", &Words::fence_mask}, {"RESET_DSP", &Words::reset_dsp},
      {"LINK_ADAPTER", &Words::link_adapter}, {"LINK_WORDS", &Words::link_words}, {"LINK_STATUS", &Words::link_status},
      {"LINK_DATA", &Words::link_data}, {"LINK_REQUEST", &Words::link_request},
      {"CR_BASE", &Words::cr_base}, {"CR_POINT_PERIOD", &Words::cr_point_period},
      {"CR_SERVO_PERIOD", &Words::cr_servo_period}, {"CR_POINT_TICKS", &Words::cr_point_ticks},
      {"CR_SERVO_TICKS", &Words::cr_servo_ticks}, {"CR_LEG", &Words::cr_leg}, {"LEG_ALIGN", &Words::leg_align}, {"CR_SPREADER", &Words::cr_spreader},
      {"CR_LOAD", &Words::cr_load}, {"CR_AGV", &Words::cr_agv}, {"CR_RAMP_START", &Words::cr_ramp_start},
      {"CR_CLEARANCE", &Words::cr_clearance}, {"CR_STRETCH", &Words::cr_stretch}, {"CR_AGV_DECK", &Words::cr_agv_deck},
      {"CR_BOX_HEIGHT", &Words::cr_box_height}, {"CR_HOME", &Words::cr_home}, {"CR_SPOT", &Words::cr_spot},
      {"CR_ENCODER_LAST", &Words::cr_encoder_last}, {"CR_ENCODER_TOTAL", &Words::cr_encoder_total},
      {"CR_BOX_COUNT", &Words::cr_box_count}, {"CR_BOX", &Words::cr_box}, {"CR_WORDS", &Words::cr_words},
      {"AG_BASE", &Words::ag_base}, {"AG_WORDS", &Words::ag_words}, {"AG_STEP_TIME", &Words::ag_step_time},
      {"AG_POINT_TICKS", &Words::ag_point_ticks}, {"AG_PERIOD_US", &Words::ag_period_us},
      {"AG_UNIT", &Words::ag_unit}, {"AG_LEG", &Words::ag_leg}, {"AG_PRODUCED", &Words::ag_produced}, {"AG_AVOID_LIMIT", &Words::ag_avoid_limit},
      {"AG_AVOID_BESIDE", &Words::ag_avoid_beside},
      {"AG_SEGMENT_COUNT", &Words::ag_segment_count}, {"AG_SEGMENT", &Words::ag_segment},
      {"AGV_UNIT", &Words::agv_unit}, {"AGV_UNIT_WORDS", &Words::agv_unit_words},
      {"AGV_RANGE", &Words::agv_range}, {"AGV_RANGE_WORDS", &Words::agv_range_words}, {"RANGE_WAY", &Words::range_way},
  };
  for (const auto& [name, member] : table) this->*member = symbol(name);
}

}  // namespace cmrc
