; Constants of the avoidance kernels (m, s, rad).

K_AV_FRACTION       .set $ - LIFT
                    .float 65536.0
K_AV_NO_LIMIT       .set $ - LIFT
                    .float 1000.0
K_AV_AHEAD          .set $ - LIFT
                    .float 45.0                 ; m, look-ahead along the lane
K_AV_BEHIND         .set $ - LIFT
                    .float -15.0
K_AV_BEYOND         .set $ - LIFT
                    .float 40.0                 ; straight extension behind the end of the leg
K_AV_ACROSS         .set $ - LIFT
                    .float 11.0                 ; m: things farther beside the lane do not matter
K_AV_STANDS         .set $ - LIFT
                    .float 8.0                  ; m: farther things do not matter to the methods (to avoid_motion they
                                                ; do)
K_AV_OVERLAP_LOW    .set $ - LIFT
                    .float -0.5                 ; overlap of the lane's pieces, for points whose foot is on a joint
K_AV_CLOSE_AHEAD    .set $ - LIFT
                    .float 12.0
K_AV_CLOSE_SPEED    .set $ - LIFT
                    .float 2.0                  ; m/s
K_AV_SHIFTING       .set $ - LIFT
                    .float 0.5                  ; m from the shift wanted: beyond, no faster than
K_AV_SHIFT_SPEED    .set $ - LIFT
                    .float 2.5                  ; m/s
K_AV_SHIFT_MOST     .set $ - LIFT
                    .float 2.5
K_AV_HOLD_WITHIN    .set $ - LIFT
                    .float 25.0
K_AV_GROUP          .set $ - LIFT
                    .float 8.0                  ; m: a thing so close behind the first is passed with the first
K_AV_NEAR           .set $ - LIFT
                    .float 8.0                  ; m: what blocks the way within this distance must stay in view
K_AV_HOME_STRAIGHT  .set $ - LIFT
                    .float 25.0                 ; before the end of the leg there is no shift
K_AV_FRONT          .set $ - LIFT
                    .float 4.0                  ; m by which the way to a shift begins later than the middle's: front
                                                ; first
K_AV_BLEND          .set $ - LIFT
                    .float 0.06666667           ; 1 / 15 m, the length of a change of shift
K_AV_T              .set $ - LIFT
                    .float 0.5
K_AV_T_SQUARED      .set $ - LIFT
                    .float 0.25
K_AV_STAND          .set $ - LIFT
                    .float 1.5                  ; distance to stop before a thing
K_AV_ONE_OVER_BIN   .set $ - LIFT
                    .float 0.6666667            ; 1 / 1.5 m
K_AV_MOVES          .set $ - LIFT
                    .float 0.25                 ; m/s: slower things count as standing
K_AV_MOVES_MOST     .set $ - LIFT
                    .float 3.0                  ; m/s
K_AV_COMES          .set $ - LIFT
                    .float 0.5                  ; m/s: the AGV lets a thing pass that comes along beside the way this
                                                ; fast
K_AV_CROSSES        .set $ - LIFT
                    .float 0.6                  ; m/s: a thing that enters the way at this speed is remembered
K_AV_PASSES         .set $ - LIFT
                    .float 22.0                 ; m for a thing to move past the vehicle; half as much again for speed
                                                ; errors
K_AV_BESIDE         .set $ - LIFT
                    .float 4.5                  ; m: a thing so far beside leaves room for any shift; so far ahead, it
                                                ; is not yet beside
K_AV_SOON           .set $ - LIFT
                    .float 2.0                  ; m ahead of the front

; potential field
K_PF_REACH          .set $ - LIFT
                    .float 0.04                 ; 1 / d0, d0 = 25 m
K_PF_MOST           .set $ - LIFT
                    .float 1.0e-4               ; 1/m^3, limit of one obstacle's force
K_PF_COS            .set $ - LIFT
                    .float 0.5                  ; angle by which forces are turned: 60 degrees
K_PF_SIN            .set $ - LIFT
                    .float 0.8660254
K_PF_SHIFT          .set $ - LIFT
                    .float 30000.0              ; m per force: repulsion over the spring that draws to the lane
K_PF_SLOW           .set $ - LIFT
                    .float 3000.0               ; speed = K_PF_FASTEST / (1 + this force)
K_PF_FASTEST        .set $ - LIFT
                    .float 6.0

; vector-field histogram
K_VF_ACTIVE         .set $ - LIFT
                    .float 25.0                 ; m, reach of the active window
K_VF_ONE_OVER       .set $ - LIFT
                    .float 0.04
K_VF_SINE_MOST      .set $ - LIFT
                    .float 0.98
K_VF_ASIN3          .set $ - LIFT
                    .float 0.16666667
K_VF_ASIN5          .set $ - LIFT
                    .float 0.075
K_VF_THRESHOLD      .set $ - LIFT
                    .float 0.02                 ; a sector below this value is free
K_VF_NINTH          .set $ - LIFT
                    .float 0.11111111
K_VF_LOOK           .set $ - LIFT
                    .float 10.0                 ; m ahead of the front: point of the lane to steer for
K_VF_FASTEST        .set $ - LIFT
                    .float 6.0
K_VF_SLOWING        .set $ - LIFT
                    .float 0.7
K_VF_NEAR           .set $ - LIFT
                    .float 4.0

; dynamic window
K_DW_UP             .set $ - LIFT
                    .float 0.75                 ; m/s, window of speeds: down 1.5, up 0.75 from the present one
K_DW_DOWN           .set $ - LIFT
                    .float 1.5
K_DW_FASTEST        .set $ - LIFT
                    .float 6.0
K_DW_TENTH          .set $ - LIFT
                    .float 0.1
K_DW_BEND           .set $ - LIFT
                    .float 0.01                 ; 1/m between samples of curvature
K_DW_STEP           .set $ - LIFT
                    .float 0.4                  ; s between the steps of an arc
K_DW_FAR            .set $ - LIFT
                    .float 1000.0               ; m, place of unused discs
K_DW_LOOK           .set $ - LIFT
                    .float 12.0                 ; m, length of the arc whose end is compared with the lane
K_DW_CLEAR_MOST     .set $ - LIFT
                    .float 2.0
K_DW_W_SPEED        .set $ - LIFT
                    .float 0.5                  ; per m/s
K_DW_W_CLEAR        .set $ - LIFT
                    .float 1.0                  ; per m
K_DW_W_LANE         .set $ - LIFT
                    .float 0.6                  ; per m
K_DW_WORST          .set $ - LIFT
                    .float -1.0e6
K_DW_EASY2          .set $ - LIFT
                    .float 6.25                 ; m^2, farther discs are not near
K_DW_FAR2           .set $ - LIFT
                    .float 1.0e9
K_DW_STEP_LEAST     .set $ - LIFT
                    .float 1.6                  ; m
