"""A hand-written OpenDRIVE file: two roads in a row with a junction between them."""

from __future__ import annotations

_MAP = """<?xml version="1.0"?>
<OpenDRIVE>
  <header revMajor="1" revMinor="7"><geoReference>+proj=tmerc +lat_0=47 +lon_0=11</geoReference></header>
  <road id="1" length="60.0" junction="-1">
    <link><successor elementType="junction" elementId="9"/></link>
    <planView>
      <geometry s="0" x="-60" y="0" hdg="0" length="40"><line/></geometry>
      <geometry s="40" x="-20" y="0" hdg="0" length="20"><arc curvature="1e-12"/></geometry>
    </planView>
    <elevationProfile><elevation s="0" a="5" b="0.01" c="0" d="0"/></elevationProfile>
    <lanes>
      <laneSection s="0">
        <left>{left}</left><center><lane id="0" type="none"/></center><right>{right}</right>
      </laneSection>
    </lanes>
  </road>
  <road id="2" length="50" junction="-1">
    <link><predecessor elementType="junction" elementId="9"/></link>
    <planView><geometry s="0" x="10" y="0" hdg="0" length="50"><line/></geometry></planView>
    <elevationProfile><elevation s="0" a="5.7" b="0.01" c="0" d="0"/></elevationProfile>
    <lanes><laneSection s="0"><left>{left}</left><center><lane id="0" type="none"/></center><right>{right}</right>
    </laneSection></lanes>
  </road>
  <road id="3" length="10" junction="9">
    <link><predecessor elementType="road" elementId="1" contactPoint="end"/>
      <successor elementType="road" elementId="2" contactPoint="start"/></link>
    <planView><geometry s="0" x="0" y="0" hdg="0" length="10"><line/></geometry></planView>
    <elevationProfile><elevation s="0" a="5.6" b="0.01" c="0" d="0"/></elevationProfile>
    <lanes><laneSection s="0"><center><lane id="0" type="none"/></center><right>{through}</right>
    </laneSection></lanes>
  </road>
  <road id="4" length="10" junction="9">
    <link><predecessor elementType="road" elementId="2" contactPoint="start"/>
      <successor elementType="road" elementId="1" contactPoint="end"/></link>
    <planView><geometry s="0" x="10" y="0" hdg="3.141592653589793" length="10"><line/></geometry></planView>
    <elevationProfile><elevation s="0" a="5.7" b="-0.01" c="0" d="0"/></elevationProfile>
    <lanes><laneSection s="0"><center><lane id="0" type="none"/></center><right>{back}</right>
    </laneSection></lanes>
  </road>
  <junction id="9">
    <connection id="0" incomingRoad="1" connectingRoad="3" contactPoint="start">
      <laneLink from="-1" to="-1"/></connection>
    <connection id="1" incomingRoad="2" connectingRoad="4" contactPoint="start">
      <laneLink from="1" to="-1"/></connection>
  </junction>
</OpenDRIVE>
"""


def _lane(lane_id: int, link: str = "") -> str:
    width = '<width sOffset="0" a="3.5" b="0" c="0" d="0"/>'
    return f'<lane id="{lane_id}" type="driving"><link>{link}</link>{width}</lane>'


def tiny_map() -> str:
    """Return the text of the file, without a fault."""
    return _MAP.format(
        left=_lane(1),
        right=_lane(-1),
        through=_lane(-1, '<predecessor id="-1"/><successor id="-1"/>'),
        back=_lane(-1, '<predecessor id="1"/><successor id="1"/>'),
    )
