"""Plans in the formats of other programs, written by hand after the formats' documents.

All say the same way: from HOME to A, then to B, at 5 m where the format can say a depth.
"""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Callable
from typing import Any

HOME = (30.2874595, 120.1535765)
A, B = (30.2882, 120.1540), (30.2885, 120.1546)


def gpx(a: tuple[float, float] = A, extra: str = "", head: str = "") -> bytes:
    return f"""<?xml version="1.0"?>{head}
<gpx version="1.1" xmlns="http://www.topografix.com/GPX/1/1" xmlns:opencpn="http://www.opencpn.org">
 <wpt lat="30.1" lon="120.2"/>
 <rte><name>harbour</name>
  <rtept lat="{a[0]}" lon="{a[1]}"><ele>-5</ele><name>Buoy 1</name><extensions>
   <opencpn:arrival_radius>0.01</opencpn:arrival_radius></extensions></rtept>
  <rtept lat="{B[0]}" lon="{B[1]}"><ele>-5</ele></rtept>
 </rte>{extra}
</gpx>""".encode()


def geojson(a: tuple[float, float] = A, **more: Any) -> bytes:
    line = [[a[1], a[0], -5], [B[1], B[0], -5]]
    feature = {
        "type": "Feature",
        "properties": {"name": "harbour"},
        "geometry": {"type": "LineString", "coordinates": line},
    }
    area = {"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": []}}
    return json.dumps({"type": "FeatureCollection", "features": [area, feature], **more}).encode()


def kml(a: tuple[float, float] = A, mode: str = "absolute") -> bytes:
    return f"""<?xml version="1.0"?>
<kml xmlns="http://www.opengis.net/kml/2.2"><Document>
 <Placemark><name>mooring</name><Point><coordinates>120.1,30.2,0</coordinates></Point></Placemark>
 <Placemark><name>harbour</name><LineString><altitudeMode>{mode}</altitudeMode><coordinates>
   {a[1]},{a[0]},-5
   {B[1]},{B[0]},-5
 </coordinates></LineString></Placemark></Document></kml>""".encode()


def zipped(content: bytes, name: str) -> bytes:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("pictures/readme.txt", "no plan")
        archive.writestr(name, content)
    return made.getvalue()


def item(command: int, *numbers: float | None, frame: int = 3) -> dict[str, Any]:
    values = [*numbers, *([None] * (7 - len(numbers)))]
    return {"type": "SimpleItem", "command": command, "frame": frame, "params": values}


def waypoint(place: tuple[float, float], height: float = -5.0, frame: int = 3) -> dict[str, Any]:
    return item(16, 0, None, None, None, place[0], place[1], height, frame=frame)


def plan(items: list[dict[str, Any]] | None = None, fence: dict[str, Any] | None = None) -> bytes:
    survey = {
        "type": "ComplexItem",
        "complexItemType": "survey",
        "TransectStyleComplexItem": {"Items": [waypoint(B)]},
    }
    return json.dumps(
        {
            "fileType": "Plan",
            "geoFence": fence or {"circles": [], "polygons": []},
            "rallyPoints": {"points": [[30.2875, 120.1536, 0]]},
            "mission": {
                "items": items if items is not None else [waypoint(A), item(201), survey],
                "plannedHomePosition": [*HOME, 0],
            },
        }
    ).encode()


def wpl(rows: list[str] | None = None, header: str = "QGC WPL 110") -> bytes:
    home = f"0\t1\t0\t16\t0\t0\t0\t0\t{HOME[0]}\t{HOME[1]}\t550\t1"
    usual = [
        home,
        "1\t0\t3\t178\t0\t0.75\t0\t0\t0\t0\t0\t1",
        f"2\t0\t3\t16\t0\t0\t0\t0\t{A[0]}\t{A[1]}\t-5\t1",
        f"3  0  3  16  0  0  0  0  {B[0]}  {B[1]}  -5  1",
    ]
    return "\n".join([header, *(rows if rows is not None else usual), ""]).encode()


def neptus_node(name: str, inner: str, start: bool = False) -> str:
    first = ' start="true"' if start else ""
    return (
        f"""<node{first}><id>{name}</id><maneuver><minTime>0</minTime>{inner}</maneuver></node>"""
    )


def neptus_goto(latitude: str, longitude: str, more: str = "") -> str:
    return f"""<Goto kind="automatic"><finalPoint type="pointType"><point><coordinate>
<latitude>{latitude}</latitude><longitude>{longitude}</longitude>{more}
<z>5.0</z><zunits>DEPTH</zunits></coordinate></point></finalPoint>
<speed type="float" unit="MPS">0.75</speed></Goto>"""


NEPTUS_NODES = neptus_node("one", neptus_goto("30N17'17.52''", "120E9.24'"), start=True)
NEPTUS_NODES += neptus_node("two", neptus_goto("30.2885N", "E120.1546"))
NEPTUS_EDGE = "<edge><source>one</source><target>two</target><guard>ManeuverIsDone</guard></edge>"


def neptus(graph: str = NEPTUS_NODES + NEPTUS_EDGE) -> bytes:
    return f"""<mission-def><definitions><home-reference><coordinate>
<latitude>{HOME[0]}</latitude><longitude>{HOME[1]}</longitude></coordinate></home-reference>
</definitions><body><plan id="harbour"><graph>{graph}</graph></plan>
<plan id="other"><graph>{neptus_node("x", "<Launch/>")}</graph></plan></body></mission-def>""".encode()


def slocum(rows: str = "", name: str = "goto_list") -> bytes:
    usual = "12009.2400 3017.2920  # | A\n\t12009.2760\t3017.3100\n"
    return f"""behavior_name={name}
# Points of Córdoba
<start:b_arg>
    b_arg: num_legs_to_run(nodim) -1  # loop
    b_arg: list_when_wpt_dist(m) 15
    b_arg: initial_wpt(enum) -2
<end:b_arg>
<start:waypoints>
#  LON   LAT
{rows or usual}<end:waypoints>
""".encode("latin-1")


def moos(points: str = "pts={40.7,82.3 : 98.5,115.6}", more: str = "") -> bytes:
    return f"""initialize DEPLOY = false
Behavior = BHV_Waypoint
{{
  name = harbour   // the way
  condition = DEPLOY = true
  speed = 0.75
  capture_radius = 5
  points = {points}{more}
}}
Behavior = BHV_Loiter {{
  name = wait
}}
""".encode()


# format -> suffix, bytes; those that can be made from a given first point
PLANS: dict[str, tuple[str, bytes]] = {
    "gpx": (".gpx", gpx()),
    "geojson": (".geojson", geojson()),
    "kml": (".kml", kml()),
    "plan": (".plan", plan()),
    "wpl": (".waypoints", wpl()),
    "neptus": (".nmis", neptus()),
    "slocum": (".ma", slocum()),
    "moos": (".bhv", moos()),
}
PLACED: dict[str, Callable[[tuple[float, float]], bytes]] = {
    "gpx": gpx,
    "geojson": geojson,
    "kml": kml,
    "plan": lambda a: plan([waypoint(a)]),
    "wpl": lambda a: wpl([f"0 0 3 16 0 0 0 0 {a[0]} {a[1]} -5 1"]),
    "neptus": lambda a: neptus(neptus_node("n", neptus_goto(str(a[0]), str(a[1])), True)),
}
