"""Sequences in which accesses wait for each other: ports of the RAM blocks, external buses, fetches beside data
(c40-hardware.md 7.4)."""

from drawings import B0, B1, GLOBAL, LOCAL, WAIT, Case

CASES = [
    # ---- 7.4: ports of the RAM blocks
    Case(
        "an unrelated instruction between store and loads",
        """
        FDRE            stf r0,*ar0
         FDRE           nop
          FDRE          ldf *ar1,r1 || ldf *ar2,r2
        """,
        3,
        {"AR0": B0, "AR1": B0 + 1, "AR2": B0 + 2},
    ),
    Case(
        "a store and one of the two loads in its block are two accesses",
        """
        FDRE            stf r0,*ar0
         FDRE           ldf *ar1,r1 || ldf *ar2,r2
        """,
        2,
        {"AR0": B0, "AR1": B0 + 1, "AR2": B1},
    ),
    Case(
        "each block takes a store and a load",
        """
        FDRE            stf r0,*ar0 || stf r1,*ar1
         FDRE           ldf *ar2,r2 || ldf *ar3,r3
        """,
        2,
        {"AR0": B0, "AR1": B1, "AR2": B0 + 1, "AR3": B1 + 1},
        code=LOCAL,
    ),
    Case(
        "two stores, an unrelated instruction, a load",
        """
        FDRE            stf r0,*ar0 || stf r1,*ar1
         FDRE           nop
          FDRE          ldf *ar2,r2
        """,
        3,
        {"AR0": B0, "AR1": B0 + 1, "AR2": B0 + 2},
    ),
    Case(
        "the store of a multiplication, then two loads: the store wins",
        """
        FDRE            mpyf3 *ar0,r1,r0 || stf r2,*ar1
         FD-RE          ldf *ar2,r2 || ldf *ar3,r3
        """,
        3,
        {"AR0": B0, "AR1": B0 + 1, "AR2": B0 + 2, "AR3": B0 + 3},
    ),
    Case(
        "the store beside a load, then the two operands of an addition",
        """
        FDRE            ldf *ar0,r0 || stf r1,*ar1
         FD-RE          addf3 *ar2,*ar3,r2
        """,
        3,
        {"AR0": B0, "AR1": B0 + 1, "AR2": B0 + 2, "AR3": B0 + 3},
    ),
    Case(
        "a register conflict has let the stores pass",
        """
        FDRE            addi 1,ar0
         FDRE           stf r0,*ar1 || stf r1,*ar2
          F-DRE         ldf *ar0,r2
        """,
        4,
        {"AR0": B0, "AR1": B0 + 8, "AR2": B0 + 9},
    ),
    Case(
        "one datum and one fetch are what the code's block serves in a cycle",
        """
        FDRE            ldi *ar0,r0
         FDRE           nop
          FDRE          nop
           FDRE         nop
            FDRE        nop
        """,
        5,
        {"AR0": B1},
    ),
    Case(
        "two stores into the code's block in cycle 0: the fetch of that cycle comes in cycle 1",
        """
        FDRE            stf r0,*ar0 || stf r1,*ar1
         FDRE           nop
          FDRE          nop
            FDRE        nop
             FDRE       nop
        """,
        6,
        {"AR0": B1, "AR1": B1 + 1},
    ),
    Case(
        "reads in cycles -1 and 0 keep the third fetch away until cycle 1",
        """
        FDRE            addf3 *ar0,*ar1,r0
         FDRE           addf3 *ar0,*ar1,r1
            FDRE        nop
             FDRE       nop
              FDRE      nop
               FDRE     nop
        """,
        8,
        {"AR0": B1, "AR1": B1 + 1},
    ),
    Case(
        "loads held up by a store: while they hold the pipeline, nothing is fetched that they could hold up",
        """
        FDRE            stf r0,*ar0
         FD-RE          ldf *ar1,r1 || ldf *ar2,r2
          FD-RE         nop
           F-DRE        nop
             FDRE       nop
              FDRE      nop
        """,
        7,
        {"AR0": B1, "AR1": B1 + 1, "AR2": B1 + 2},
    ),
    # ---- 7.4: external buses
    Case(
        "read, write (cycles 1 and 2), read straight after it: 2 cycles",
        """
        FDRE            ldi *ar0,r0
         FDRE           sti r1,*ar1
          FD---RE       ldi *ar2,r2
        """,
        6,
        {"AR0": LOCAL, "AR1": LOCAL + 1, "AR2": LOCAL + 2},
    ),
    Case(
        "the write of cycles 0 and 1 and a read one instruction later",
        """
        FDRE            sti r0,*ar0
         FDRE           nop
          FD--RE        ldi *ar1,r1
        """,
        5,
        {"AR0": LOCAL, "AR1": LOCAL + 1},
    ),
    Case(
        "two instructions later it is still straight after the write",
        """
        FDRE            sti r0,*ar0
         FDRE           nop
          FDRE          nop
           FD-RE        ldi *ar1,r1
        """,
        5,
        {"AR0": LOCAL, "AR1": LOCAL + 1},
    ),
    Case(
        "three later it is not",
        """
        FDRE            sti r0,*ar0
         FDRE           nop
          FDRE          nop
           FDRE         nop
            FDRE        ldi *ar1,r1
        """,
        5,
        {"AR0": LOCAL, "AR1": LOCAL + 1},
    ),
    Case(
        "two stores at once, one to each bus",
        """
        FDRE            sti r0,*ar0 || sti r1,*ar1
         FDRE           nop
        """,
        2,
        {"AR0": LOCAL, "AR1": GLOBAL},
    ),
    Case(
        "stores that alternate between the buses find them free",
        """
        FDRE            sti r0,*ar0
         FDRE           sti r1,*ar1
          FDRE          sti r2,*ar2
        """,
        3,
        {"AR0": LOCAL, "AR1": GLOBAL, "AR2": LOCAL + 1},
    ),
    Case(
        "a wait state holds everything for a cycle",
        """
        FDRRE           ldi *ar0,r0
         FD-RE          nop
        """,
        3,
        {"AR0": WAIT},
    ),
    Case(
        "a slow read beside one on chip",
        """
        FDRRE           ldf *ar0,r0 || ldf *ar1,r1
        """,
        2,
        {"AR0": WAIT, "AR1": B0},
    ),
    Case(
        "two slow reads on one bus",
        """
        FDRRRRE         ldf *ar0,r0 || ldf *ar1,r1
        """,
        4,
        {"AR0": WAIT, "AR1": WAIT + 1},
    ),
    Case(
        "two slow reads, one of them on the other bus without a wait",
        """
        FDRRE           ldf *ar0,r0 || ldf *ar1,r1
        """,
        2,
        {"AR0": WAIT, "AR1": GLOBAL},
    ),
    Case(
        "a slow write is cycles 0 to 2, the next one 3 to 5: it waits in E",
        """
        FDRE            sti r0,*ar0
         FDR--E         sti r1,*ar1
        """,
        4,
        {"AR0": WAIT, "AR1": WAIT + 1},
    ),
    Case(
        "and a slow read straight after it is cycles 3 to 5, its own two the last",
        """
        FDRE            sti r0,*ar0
         FD----RRE      ldi *ar1,r1
        """,
        7,
        {"AR0": WAIT, "AR1": WAIT + 1},
    ),
    Case(
        "a refill hides the slow write, and a cycle lies between it and the read",
        """
        FDRE            sti r0,*ar0
         FDRE           br go
                        nop
             FDRRE      go: ldi *ar1,r1
        """,
        7,
        {"AR0": WAIT, "AR1": WAIT + 1},
    ),
    Case(
        "the return address through slow memory: its write is cycles 0 to 2, its read straight after it, 3 to 5",
        """
        FDRE            call f
                  FDRE  br go
            FD-RRE      f: rets
                        go:
        """,
        14,
        {"SP": WAIT},
    ),
    # ---- code and data on one external bus
    Case(
        "the read of cycle -1 keeps that cycle's fetch away",
        """
        FDRE            ldi *ar0,r0
         FDRE           nop
           FDRE         nop
            FDRE        nop
             FDRE       nop
        """,
        6,
        {"AR0": LOCAL + 0x100},
        code=LOCAL,
    ),
    Case(
        "the write of cycles 0 and 1 does, and the fetch straight after it takes 2 cycles",
        """
        FDRE            sti r0,*ar0
         FDRE           nop
          FDRE          nop
              FDRE      nop
               FDRE     nop
                FDRE    nop
        """,
        9,
        {"AR0": LOCAL + 0x100},
        code=LOCAL,
    ),
]
