; RC + 1 words from *AR0++ to *AR1++.
copy_words:
        rptb    copy_words_last
        ldi     *ar0++, r0
copy_words_last:
        sti     r0, *ar1++
        rets

