; The second half of the survey, for the first task to fetch from this one's area.
kernel_survey_second:
        call    survey_begin
        ldi     SU_HALF, r9
        ldi     SU_HALF, r10
        call    survey
        ldi     0, r8
        br      survey_end
