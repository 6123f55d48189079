; The first half of the survey, and the whole put together: the second task's area follows this one's. TB_RESULT:
SURVEY_JOINED   .set 0                  ; the halves are of one scan
SURVEY_ALONE    .set 1                  ; the second half did not come in time: this task has done it itself
SURVEY_APART    .set 2                  ; joined, but the halves are of two scans

kernel_survey_first:
        call    survey_begin
        ldi     0, r9
        ldi     SU_HALF, r10
        call    survey
        ldi     *+ar6(SU_PATIENCE), r0
        sti     r0, @SU_LEFT
first_look:
        ldi     *+ar6(US_WORDS + SU_TICK), r0
        cmpi    @TASK + TB_TICK, r0
        beq     first_join
        call    alive                   ; a sign of life, and a write: drops the bridge's line, and the next look isnew
        rpts    63                      ; let the other have the bus
        nop
        ldi     @SU_LEFT, r0
        subi    1, r0
        sti     r0, @SU_LEFT
        bgt     first_look
        ldi     SU_HALF, r9             ; it is late, or dead
        ldi     SU_HALF, r10
        call    survey
        ldi     SURVEY_ALONE, r8
        br      first_end
first_join:
        ldi     ar6, ar0
        addi    US_WORDS + SU_SECTOR + SU_HALF, ar0
        ldhi    hi16(SU_TABLE + SU_HALF), ar1
        or      lo16(SU_TABLE + SU_HALF), ar1
        ldi     SU_HALF - 1, rc
        call    copy_words
        float   *+ar6(US_WORDS + SU_FREE), r0
        cmpf    @SU_NEAREST, r0
        ldfgt   @SU_NEAREST, r0
        stf     r0, @SU_NEAREST
        ldi     SURVEY_JOINED, r8
        ldi     *+ar6(US_WORDS + SU_SCAN), r0
        cmpi    @SU_SEEN, r0
        ldine   SURVEY_APART, r8
first_end:
        ldi     0, r9
        ldi     SU_SECTORS, r10
        br      survey_end
