"""The six claims of paper section 7 and the cost of missed deadlines, each with its experiment: ``python -m
cmrc.results`` regenerates docs/results.md.

Each claim is a module with ``Parameters`` (each field made by ``judgement.parameter``, with its text for ``--help``),
``QUICK`` (a small version), and the functions ``runs`` (the runs to make), ``rows`` (the numbers, from the runs'
reports), ``verdict`` (from the rows alone), ``section`` (text and tables) and ``draw`` (the plot).
"""
