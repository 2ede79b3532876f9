"""FANUC Series 30i, increment system IS-C (0.0001 mm and degree).

Axis values are machine positions in `G54`, whose offsets must be zero: the program compares workpiece and
machine position of every axis (#5041 and #5021 onwards; X Y Z A B W C are axes 1 to 7 of the path) before
anything moves, then where the machine stands, and stops with alarm 3001 or 3002. `G93`: F is the reciprocal
of the time for the block in minutes, here the largest speed of the block's path parameter, so it holds for
linear and rotary axes alike; it stands in every block and is at most 9999.999: shorter blocks run slower
than planned, never faster. Acceleration and jerk are the axes' own, which must be those of the machine
definition named in the header. `G61` stops exactly at the end of every block and is never taken back; `G5.1
Q0` switches contour control off.

T is the number of a die, M701 and on that of a process, M801 and on that of a hand-shake, as the header lists
them. Every M function is finished (FIN) before the next block runs: that of a hand-shake when its signal is
there; when the time in its name is over without, the machine stops with an alarm.
"""

from robots.post.events import EVENT_CALLS
from robots.post.form import AXES, Form
from robots.post.grammar import Calls, Grammar

CALLS = Calls(start="T{k} M59", change="T{k} M6", process="M7{k:02d}", wait="M8{k:02d}", events=EVENT_CALLS)

_OFFSETS = tuple(
    f"IF[ABS[#{5041 + i}-#{5021 + i}]GT0.00005]THEN #3000=1(ZERO OFFSET IN {axis})"
    for i, axis in enumerate(AXES)
)
_PLACES = tuple(
    f"IF[ABS[#{5021 + i}-[{{{axis}}}]]GT0.05]THEN #3000=2(NOT AT START IN {axis})"
    for i, axis in enumerate(AXES)
)

GRAMMAR = Grammar(
    form=Form(angle_digits=4, feed_digits=3, max_feed=9999.999),
    top=("%", "O1000"),
    note="({})",
    opening=("G17 G21 G40 G49 G69 G80 G90", "G54 G61 G93", "G5.1 Q0"),
    rest=("N{n} ({why})",),
    motion=("N{n} G1 X{X} Y{Y} Z{Z} A{A} B{B} W{W} C{C} F{F} ({why})",),
    position=(*_OFFSETS, *_PLACES),
    closing=("M30", "%"),
    calls=CALLS,
    width=250,
)
