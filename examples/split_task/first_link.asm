; As first.asm, but the second half comes over a link, to port 0: release, scan, free way, sectors.
kernel_survey_first_link:
        call    survey_begin
        ldi     0, r9
        ldi     SU_HALF, r10
        call    survey
        ldi     *+ar6(SU_PATIENCE), r0
        sti     r0, @SU_LEFT
        ldhi    0010h, ar2
        or      0040h, ar2
first_link_tick:
        call    link_word
        cmpi    0, r1
        beq     first_link_alone
        cmpi    @TASK + TB_TICK, r0
        bne     first_link_tick         ; left over from a release for which it came too late
        call    link_word
        cmpi    0, r1
        beq     first_link_alone
        ldi     SURVEY_JOINED, r8
        cmpi    @SU_SEEN, r0
        ldine   SURVEY_APART, r8
        call    link_word
        cmpi    0, r1
        beq     first_link_alone
        float   r0, r0
        cmpf    @SU_NEAREST, r0
        ldfgt   @SU_NEAREST, r0
        stf     r0, @SU_NEAREST
        ldhi    hi16(SU_TABLE + SU_HALF), ar3
        or      lo16(SU_TABLE + SU_HALF), ar3
        ldi     SU_HALF - 1, ar1
first_link_sector:
        call    link_word
        cmpi    0, r1
        beq     first_link_alone
        sti     r0, *ar3++
        db      ar1, first_link_sector
        br      first_end
first_link_alone:                       ; the other half is late, or dead
        ldi     SU_HALF, r9
        ldi     SU_HALF, r10
        call    survey
        ldi     SURVEY_ALONE, r8
        br      first_end

; R0 <- the next word of the port at AR2, R1 <- 1; or R1 <- 0 when no look is left.
link_word:
        ldi     *ar2, r0
        lsh     -9, r0
        and     15, r0                  ; INPUT LEVEL
        bnz     link_there
        ldi     @SU_LEFT, r1
        subi    1, r1
        sti     r1, @SU_LEFT
        ble     link_none
        call    alive
        rpts    127
        nop
        br      link_word
link_there:
        ldi     *+ar2(1), r0
        ldi     1, r1
        rets
link_none:
        ldi     0, r1
        rets
