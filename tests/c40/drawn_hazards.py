"""Sequences in which address generation waits for a register (c40-hardware.md 7.3), or a refill hides a wait (7.2)."""

from drawings import B0, WAIT, Case

CASES = [
    # ---- 7.3: registers that address generation waits for
    Case(
        "an index register is ready after E of cycle 0, like ARn",
        """
        FDRE            ldi 5,ir0
         F--DRE         ldf *+ar0(ir0),r0
        """,
        4,
        {"AR0": B0},
    ),
    Case(
        "so is BK",
        """
        FDRE            ldi 8,bk
         F--DRE         ldf *ar0++(1)%,r0
        """,
        4,
        {"AR0": B0},
    ),
    Case(
        "so is SP, for PUSH",
        """
        FDRE            ldi r0,sp
         F--DRE         push r1
        """,
        4,
        {"R0": B0},
    ),
    Case(
        "a word popped into ARn is an ordinary write",
        """
        FDRE            pop ar0
         F--DRE         ldi *ar0,r0
        """,
        4,
        {"SP": B0},
        {B0: B0 + 8},
    ),
    Case(
        "so is a word loaded into it",
        """
        FDRE            ldi *ar0++,ar1
         F--DRE         ldf *ar1,r0
        """,
        4,
        {"AR0": B0},
        {B0: B0 + 8},
    ),
    Case(
        "of two registers the later one counts",
        """
        FDRE            addi 1,ar0
         FDRE           addi 1,ar1
          F--DRE        ldf *ar0,r0 || ldf *ar1,r1
        """,
        5,
        {"AR0": B0, "AR1": B0 + 8},
    ),
    Case(
        "three writes, the newest is one of the two that are used",
        """
        FDRE            addi 1,ar0
         FDRE           addi 1,ar1
          FDRE          addi 1,ar2
           F--DRE       ldf *ar0,r0 || ldf *ar2,r1
        """,
        6,
        {"AR0": B0, "AR1": B0 + 8, "AR2": B0 + 16},
    ),
    Case(
        "one instruction between leaves one stall, and the instruction after finds none",
        """
        FDRE            subi 1,ar0
         FDRE           ldi 3,r0
          F-DRE         ldi *ar0,r1
            FDRE        ldi *ar0,r2
        """,
        5,
        {"AR0": B0},
    ),
    Case(
        "DP written in E, one instruction between",
        """
        FDRE            ldi 2fh,dp
         FDRE           nop
          F-DRE         ldi @0f900h,r0
        """,
        4,
    ),
    Case(
        "LDA is ready one cycle earlier, for an index register too",
        """
        FDRE            lda *ar3,ir1
         F-DRE          ldf *ar0++(ir1),r0
        """,
        3,
        {"AR3": B0, "AR0": B0 + 8},
        {B0: 2},
    ),
    Case(
        "LDA, then an ordinary load, each used at once: 1 and 2 stalls",
        """
        FDRE            lda *ar3,ar0
         F-DRE          ldi *ar0,ar1
           F--DRE       ldf *ar1,r0
        """,
        6,
        {"AR3": B0},
        {B0: B0 + 1, B0 + 1: B0 + 2},
    ),
    Case(
        "LDA from a wait state: the word is there when the longer R is over",
        """
        FDRRE           lda *ar3,ar0
         F--DRE         ldf *ar0,r0
        """,
        4,
        {"AR3": WAIT},
        {WAIT: B0},
    ),
    Case(
        "a register operand that is read, then addressed with",
        """
        FDRE            ldi ar1,ar0
         F-DRE          ldf *ar1,r0
        """,
        3,
        {"AR1": B0},
    ),
    Case(
        "the write of AR0 hides that AR1 was read",
        """
        FDRE            ldi ar1,ar0
         F--DRE         ldf *ar0,r0 || ldf *ar1,r1
        """,
        4,
        {"AR1": B0},
    ),
    Case(
        "read, one instruction between: no stall",
        """
        FDRE            addi ar0,r1
         FDRE           nop
          FDRE          ldf *ar0,r0
        """,
        3,
        {"AR0": B0},
    ),
    Case(
        "the register that a store writes out is an operand that is read",
        """
        FDRE            sti ar0,*ar1
         F-DRE          ldi *ar0,r0
        """,
        3,
        {"AR0": B0, "AR1": B0 + 8},
    ),
    Case(
        "so is the one that PUSH writes out",
        """
        FDRE            push ar0
         F-DRE          ldi *ar0,r0
        """,
        3,
        {"AR0": B0, "SP": B0 + 8},
    ),
    Case(
        "an update by addressing is over in D",
        """
        FDRE            nop *ar0++
         FDRE           ldi *ar0,r0
        """,
        2,
        {"AR0": B0},
    ),
    Case(
        "an index register used, written, used",
        """
        FDRE            ldi *ar0++(ir0),r0
         FDRE           ldi 3,ir0
          F--DRE        ldi *ar0++(ir0),r1
        """,
        5,
        {"AR0": B0, "IR0": 1},
    ),
    Case(
        "PUSH and POP move SP in D, and their write and read are two accesses of one block",
        """
        FDRE            push r0
         FDRE           pop r1
        """,
        2,
        {"SP": B0},
    ),
    Case(
        "DBcondD waits for its own ARn",
        """
        FDRE            ldi 3,ar0
         F--DRE         dbd ar0,go
            FDRE        nop
             FDRE       nop
              FDRE      nop
                        go:
        """,
        7,
    ),
    Case(
        "and what it counts down is an ordinary write",
        """
        FDRE            dbd ar0,go
         F--DRE         ldi *ar0,r1
            FDRE        nop
             FDRE       nop
                        go:
        """,
        6,
        {"AR0": B0 + 1},
    ),
    # ---- 7.2: a refill hides what waits behind it
    Case(
        "a standard branch hides a register conflict",
        """
        FDRE            addi 1,ar0
         FDRE           br go
                        nop
             FDRE       go: ldf *ar0,r0
        """,
        6,
        {"AR0": B0},
    ),
    Case(
        "so do the slots of a delayed one",
        """
        FDRE            addi 1,ar0
         FDRE           brd go
          FDRE          nop
           FDRE         nop
            FDRE        nop
             FDRE       go: ldf *ar0,r0
        """,
        6,
        {"AR0": B0},
    ),
    Case(
        "a stall in a slot lengthens the slots, not the branch",
        """
        FDRE            brd go
         FDRE           stf r0,*ar0 || stf r1,*ar1
          FD-RE         ldf *ar2,r2
           FD-RE        nop
                        go:
        """,
        5,
        {"AR0": B0, "AR1": B0 + 1, "AR2": B0 + 2},
    ),
]
