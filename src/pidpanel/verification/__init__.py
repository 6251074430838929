"""Every comparison with closed forms and published solutions.

`rows`
    One computed number and its reference; files of rows.
`coupon`, `panel`, `sound`, `response`
    Cases of a stage, its ``CASES``.
`page`
    The page of all cases.
"""
