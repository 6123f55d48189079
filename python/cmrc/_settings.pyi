# Written by scripts/documents/settings_stub.py from the configuration's schema (docs/configuration.md).
from os import PathLike
from typing import Literal, TypedDict

from numpy import bool_

class MoreSettings(TypedDict, total=False):
    """Keywords of cmrc.run beside its own arguments."""

    seed: int  # run.seed
    turn_order: int  # run.turn_order
    strict: bool | bool_  # run.strict
    until: Literal["duration", "job_done"]  # run.until
    after_stop_s: float  # run.after_stop_s
    ideal: bool | bool_  # run.ideal
    phase_jitter: bool | bool_  # run.phase_jitter
    slots: int  # machine.slots
    dsp_clock: Literal["C40-40", "C40-50", "C40-60"]  # machine.dsp_clock
    cycle_time_factor: float  # machine.cycle_time_factor
    boot: Literal["preloaded", "link"]  # machine.boot
    idle_policy: Literal["doorbell", "pause", "spin"]  # machine.idle_policy
    pause_nops: int  # machine.pause_nops
    guard: bool | bool_  # machine.guard
    programs: str | PathLike[str]  # machine.programs
    board: str | PathLike[str]  # machine.board
    links: str | PathLike[str]  # machine.links
    nets: str | PathLike[str]  # machine.nets
    refresh_frequency_hz: float  # rates.refresh_frequency_hz
    servo_frequency_hz: float  # rates.servo_frequency_hz
    crane_point_frequency_hz: float  # rates.crane_point_frequency_hz
    agv_point_frequency_hz: float  # rates.agv_point_frequency_hz
    equation: Literal["restored", "as_printed"]  # scheduling.equation
    gamma_refreshes: int  # scheduling.gamma_refreshes
    alpha_refreshes: int  # scheduling.alpha_refreshes
    beta_refreshes: int  # scheduling.beta_refreshes
    p: int  # scheduling.p
    q: int  # scheduling.q
    b: int  # scheduling.b
    a: int  # scheduling.a
    agv_interval_refreshes: int  # scheduling.agv_interval_refreshes
    agv_interval_max_refreshes: int  # scheduling.agv_interval_max_refreshes
    buffer_points: int  # scheduling.buffer_points
    servo_reload: Literal["locked", "inherited"]  # scheduling.servo_reload
    agv_buffer_points: int  # scheduling.agv_buffer_points
    work_mode: Literal["full_load", "slowed_agv", "slowed_crane"]  # scheduling.work_mode
    slow_factor: float  # scheduling.slow_factor
    pid_after_torque: bool | bool_  # scheduling.pid_after_torque
    long_blocks_max: int  # scheduling.long_blocks_max
    slice_cycles: int  # scheduling.slice_cycles
    time_after_delay: Literal["elapsed", "one"]  # scheduling.time_after_delay
    learning: Literal["off", "proportional", "unit"]  # scheduling.learning
    learning_rate: float  # scheduling.learning_rate
    learning_dead_band: float  # scheduling.learning_dead_band
    learning_step_max: float  # scheduling.learning_step_max
    servo_loss_share: float  # scheduling.servo_loss_share
    servo_loss_run: int  # scheduling.servo_loss_run
    servo_served_every: int  # scheduling.servo_served_every
    agv_phase: Literal["staggered", "together"]  # scheduling.agv_phase
    event_field_m: float  # scheduling.event_field_m
    event_read_refreshes: int  # scheduling.event_read_refreshes
    factor: float  # watchdog.factor
    minimum_refreshes: int  # watchdog.minimum_refreshes
    recomputations_max: int  # watchdog.recomputations_max
    retries_max: int  # watchdog.retries_max
    silence_ms: float  # watchdog.silence_ms
    semaphore_limit_us: float  # watchdog.semaphore_limit_us
    boot_limit_ms: float  # watchdog.boot_limit_ms
    servo_run_us: float  # watchdog.servo_run_us
    planning_run_us: float  # watchdog.planning_run_us
    long_run_us: float  # watchdog.long_run_us
    refresh_overhead_ns: float  # host.refresh_overhead_ns
    per_block_ns: float  # host.per_block_ns
    semaphore_retry_ns: float  # host.semaphore_retry_ns
    start_ms: float  # host.start_ms
    boot_pause_ns: float  # host.boot_pause_ns
    torque: Literal["closed_form", "newton_euler"]  # kernels.torque
    pid: Literal["error_derivative", "measurement_derivative"]  # kernels.pid
    trajectory: Literal["blend9", "quintic_shaper"]  # kernels.trajectory
    avoidance: Literal["none", "synthetic", "potential_field", "vfh", "dynamic_window"]  # kernels.avoidance
    avoidance_cycles: int  # load.avoidance_cycles
    driving: bool | bool_  # load.driving
    parked: bool | bool_  # load.parked
    clock_hz: float  # bus.clock_hz
    latency_timer_clocks: int  # bus.latency_timer_clocks
    prefetch: bool | bool_  # bus.prefetch
    fast_back_to_back: bool | bool_  # bus.fast_back_to_back
    topology: Literal["dual", "host_on_both", "sensors_with_host", "single"]  # bus.topology
    arbiter: Literal["round_robin", "fixed", "two_level", "host_fair"]  # bus.arbiter
    first_level_dsps: int  # bus.first_level_dsps
    parking: Literal["none", "last_owner", "host"]  # bus.parking
    grant_clocks: int  # bus.grant_clocks
    multi_transaction_clocks: int  # bus.multi_transaction_clocks
    request_off_clocks: int  # bus.request_off_clocks
    think_on_retry_clocks: int  # bus.think_on_retry_clocks
    max_burst_words: int  # bus.max_burst_words
    post_depth_words: int  # bus.post_depth_words
    shared_memory_card: Literal["sram", "s5933", "drive_card", "host_dram"]  # bus.shared_memory_card
    device_card: Literal["sram", "s5933", "drive_card", "host_dram"]  # bus.device_card
    delayed_reads: bool | bool_  # bus.delayed_reads
    delayed_read_clocks: int  # bus.delayed_read_clocks
    device_post_words: int  # bus.device_post_words
    buses: str | PathLike[str]  # topology.buses
    host: str | PathLike[str]  # topology.host
    boards: str | PathLike[str]  # topology.boards
    shared_memory: str | PathLike[str]  # topology.shared_memory
    drives: str | PathLike[str]  # topology.drives
    sensors: str | PathLike[str]  # topology.sensors
    comm_port: str | PathLike[str]  # topology.comm_port
    bridges: str | PathLike[str]  # topology.bridges
    drives_at: int  # topology.drives_at
    sensors_at: int  # topology.sensors_at
    comm_port_at: int  # topology.comm_port_at
    agvs: int  # dock.agvs
    containers: int  # dock.containers
    crane: Literal["slewing", "gantry"]  # dock.crane
    crane_model: Literal["sway", "rigid"]  # dock.crane_model
    container_mass_kg: float  # dock.container_mass_kg
    agv_speed_m_s: float  # dock.agv_speed_m_s
    clearance_m: float  # dock.clearance_m
    ramp_slack_m: float  # dock.ramp_slack_m
    ramp_speed_m_s: float  # dock.ramp_speed_m_s
    drive_timeout_ms: float  # dock.drive_timeout_ms
    drive_delay_us: float  # dock.drive_delay_us
    settle_limit_s: float  # dock.settle_limit_s
    landing_retries_max: int  # dock.landing_retries_max
    integrator: Literal["erk", "adams", "bdf"]  # dock.integrator
    stiction: bool | bool_  # dock.stiction
    gear_losses: bool | bool_  # dock.gear_losses
    strict_landing: bool | bool_  # dock.strict_landing
    sway_sensors: int  # dock.sway_sensors
    capture_window_m: float  # dock.capture_window_m
    layout: str | PathLike[str]  # dock.layout
    protective_field: bool | bool_  # dock.protective_field
    ship_motion: float  # dock.ship_motion
    wind_mean_m_s: float  # dock.wind_mean_m_s
    wind_gust_m_s: float  # dock.wind_gust_m_s
    wind_limit_m_s: float  # dock.wind_limit_m_s
    wind_direction_deg: float  # dock.wind_direction_deg
    travel_bandwidth_rad_s: float  # control.travel_bandwidth_rad_s
    travel_damping: float  # control.travel_damping
    travel_integral_time_s: float  # control.travel_integral_time_s
    travel_derivative_filter: float  # control.travel_derivative_filter
    travel_feed_forward: float  # control.travel_feed_forward
    travel_speed_limit_m_s: float  # control.travel_speed_limit_m_s
    slew_bandwidth_rad_s: float  # control.slew_bandwidth_rad_s
    slew_damping: float  # control.slew_damping
    slew_integral_time_s: float  # control.slew_integral_time_s
    slew_derivative_filter: float  # control.slew_derivative_filter
    slew_feed_forward: float  # control.slew_feed_forward
    slew_speed_limit_rad_s: float  # control.slew_speed_limit_rad_s
    luff_bandwidth_rad_s: float  # control.luff_bandwidth_rad_s
    luff_damping: float  # control.luff_damping
    luff_integral_time_s: float  # control.luff_integral_time_s
    luff_derivative_filter: float  # control.luff_derivative_filter
    luff_feed_forward: float  # control.luff_feed_forward
    luff_speed_limit_rad_s: float  # control.luff_speed_limit_rad_s
    trolley_bandwidth_rad_s: float  # control.trolley_bandwidth_rad_s
    trolley_damping: float  # control.trolley_damping
    trolley_integral_time_s: float  # control.trolley_integral_time_s
    trolley_derivative_filter: float  # control.trolley_derivative_filter
    trolley_feed_forward: float  # control.trolley_feed_forward
    trolley_speed_limit_m_s: float  # control.trolley_speed_limit_m_s
    hoist_bandwidth_rad_s: float  # control.hoist_bandwidth_rad_s
    hoist_damping: float  # control.hoist_damping
    hoist_integral_time_s: float  # control.hoist_integral_time_s
    hoist_derivative_filter: float  # control.hoist_derivative_filter
    hoist_feed_forward: float  # control.hoist_feed_forward
    hoist_speed_limit_m_s: float  # control.hoist_speed_limit_m_s
    rotator_bandwidth_rad_s: float  # control.rotator_bandwidth_rad_s
    rotator_damping: float  # control.rotator_damping
    rotator_integral_time_s: float  # control.rotator_integral_time_s
    rotator_derivative_filter: float  # control.rotator_derivative_filter
    rotator_feed_forward: float  # control.rotator_feed_forward
    rotator_speed_limit_rad_s: float  # control.rotator_speed_limit_rad_s
    sway_gain_m_s_rad: float  # control.sway_gain_m_s_rad
    wind_observer_rad_s: float  # control.wind_observer_rad_s
    sway_filter_s: float  # control.sway_filter_s
    sway_limit_mrad: float  # control.sway_limit_mrad
    following_travel_m: float  # errors.following_travel_m
    following_slew_mrad: float  # errors.following_slew_mrad
    following_luff_mrad: float  # errors.following_luff_mrad
    following_trolley_m: float  # errors.following_trolley_m
    following_hoist_m: float  # errors.following_hoist_m
    following_rotator_mrad: float  # errors.following_rotator_mrad
    following_ms: float  # errors.following_ms
    encoder_speed_percent: float  # errors.encoder_speed_percent
    encoder_ms: float  # errors.encoder_ms
    sway_samples: int  # errors.sway_samples
    stop_s: float  # errors.stop_s
    go_on_s: float  # errors.go_on_s
    timeout_retries_max: int  # errors.timeout_retries_max
    clear: bool | bool_  # errors.clear
    misses_max: int  # report.misses_max
    error_rows_max: int  # report.error_rows_max
    samples_max: int  # report.samples_max
    control_cost_rho_m2: float  # report.control_cost_rho_m2
    signal_decimation: int  # report.signal_decimation
    signal_rows_max: int  # report.signal_rows_max
    a0_m: float  # slewing.a0_m
    jib_m: float  # slewing.jib_m
    pivot_height_m: float  # slewing.pivot_height_m
    slew_inertia_kg_m2: float  # slewing.slew_inertia_kg_m2
    jib_mass_kg: float  # slewing.jib_mass_kg
    jib_centre_m: float  # slewing.jib_centre_m
    jib_inertia_kg_m2: float  # slewing.jib_inertia_kg_m2
    counterweight_kg: float  # slewing.counterweight_kg
    counterweight_radius_m: float  # slewing.counterweight_radius_m
    boom_height_m: float  # gantry.boom_height_m
    trolley_mass_kg: float  # gantry.trolley_mass_kg
    mass_kg: float  # agv.mass_kg
    length_m: float  # agv.length_m
    width_m: float  # agv.width_m
    front_axle_m: float  # agv.front_axle_m
    rear_axle_m: float  # agv.rear_axle_m
    yaw_inertia_kg_m2: float  # agv.yaw_inertia_kg_m2
    deck_height_m: float  # agv.deck_height_m
    cornering_n_rad: float  # agv.cornering_n_rad
    adhesion: float  # agv.adhesion
    rolling: float  # agv.rolling
    drag_n_s2_m2: float  # agv.drag_n_s2_m2
    steer_limit_deg: float  # agv.steer_limit_deg
    steer_rate_rad_s: float  # agv.steer_rate_rad_s
    steer_lag_s: float  # agv.steer_lag_s
    drive_lag_s: float  # agv.drive_lag_s
    acceleration_m_s2: float  # agv.acceleration_m_s2
    braking_m_s2: float  # agv.braking_m_s2
    emergency_m_s2: float  # agv.emergency_m_s2
    blend_speed_m_s: float  # agv.blend_speed_m_s
    track_m: float  # agv.track_m
    wheel_slip_n_s_m: float  # agv.wheel_slip_n_s_m
    protective_margin_m: float  # agv.protective_margin_m
    speed_gain_1_s: float  # agv.speed_gain_1_s
    speed_integral_1_s: float  # agv.speed_integral_1_s
    fall_stiffness_n: float  # landing.fall_stiffness_n
    fall_damping_n_s_m: float  # landing.fall_damping_n_s_m
    fall_spread_x_m: float  # landing.fall_spread_x_m
    fall_spread_y_m: float  # landing.fall_spread_y_m
    yaw_stiffness_n_m_rad: float  # landing.yaw_stiffness_n_m_rad
    yaw_damping_n_m_s_rad: float  # landing.yaw_damping_n_m_s_rad
    corner_stiffness_n_m: float  # landing.corner_stiffness_n_m
    corner_damping_n_s_m: float  # landing.corner_damping_n_s_m
    friction: float  # landing.friction
    near_m: float  # landing.near_m
    away_m: float  # landing.away_m
    guide_height_m: float  # landing.guide_height_m
    guide_stiffness_n_m: float  # landing.guide_stiffness_n_m
    guide_damping_n_s_m: float  # landing.guide_damping_n_s_m
    seat_error_m: float  # landing.seat_error_m
    seat_gap_m: float  # landing.seat_gap_m
    touch_speed_m_s: float  # landing.touch_speed_m_s
    touch_sway_m_s: float  # landing.touch_sway_m_s
    yaw_error_deg: float  # landing.yaw_error_deg
    lock_time_s: float  # landing.lock_time_s

class LimitsSettings(MoreSettings, total=False):
    """Keywords of cmrc.limits."""

    duration_s: float  # run.duration_s

class Settings(LimitsSettings, total=False):
    """Keywords of cmrc.Simulation: settings by the last part of their names."""

    dsps: int  # machine.dsps
