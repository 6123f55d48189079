"""The six claims of paper section 7 and what missed deadlines cost, each with its experiment: ``python -m
cmrc.results`` regenerates docs/results.md.

Each claim is a module with ``Parameters`` (each field by ``judgement.parameter``, with what ``--help`` says of it),
``QUICK`` (a shrunken version), and the functions ``runs`` (what to run), ``rows`` (the numbers, from the
runs' reports), ``verdict`` (from the rows alone), ``section`` (text and tables) and ``draw`` (the plot).
"""
