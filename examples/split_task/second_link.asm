; The second half of the survey, sent to the first task over a link, from port 4.
kernel_survey_second_link:
        call    survey_begin
        ldi     SU_HALF, r9
        ldi     SU_HALF, r10
        call    survey
        ldhi    0010h, ar2
        or      0080h, ar2
        ldi     @TASK + TB_TICK, r0
        sti     r0, *+ar2(2)
        ldi     @SU_SEEN, r0
        sti     r0, *+ar2(2)
        fix     @SU_NEAREST, r0
        sti     r0, *+ar2(2)
        ldhi    hi16(SU_TABLE + SU_HALF), ar0
        or      lo16(SU_TABLE + SU_HALF), ar0
        ldi     SU_HALF - 1, ar1
second_link_sector:
        ldi     *ar0++, r0
        sti     r0, *+ar2(2)
        db      ar1, second_link_sector
        ldi     0, r0
        ldi     0, r1
        rets
