"""The look of an incident dossier: on screen and on paper, told apart without colour alone. CSS only; nothing is fetched."""

CSS = """
:root{--ink:#1d2430;--dim:#5d6878;--hair:#d9dee6;--paper:#fff;--asked:#b45309;--applied:#1d4ed8;--measured:#5d6878;--rule:#b45309;
--cause:#b91c1c;--moment:#b91c1c}
*{box-sizing:border-box}
body{font:15px/1.5 system-ui,"Segoe UI","DejaVu Sans",sans-serif;color:var(--ink);background:#eef1f5;margin:0}
main{max-width:1260px;margin:0 auto;padding:28px 36px 60px;background:var(--paper)}
h1{font-size:25px;margin:0 0 2px}h2{font-size:18px;margin:34px 0 10px;padding-top:12px;border-top:2px solid var(--ink)}
h3{font-size:14px;margin:14px 0 6px;color:var(--dim);font-weight:600}
p{margin:4px 0}.lead{color:var(--dim);margin-bottom:18px}.note{color:var(--dim);font-size:13px}
dl.facts{display:grid;grid-template-columns:max-content 1fr max-content 1fr;gap:4px 18px;margin:14px 0;font-size:14px}
dl.facts dt{color:var(--dim)}dl.facts dd{margin:0;overflow-wrap:anywhere}
.at{border-left:5px solid var(--moment);background:#fdf3f3;padding:10px 16px;margin:14px 0}
table{border-collapse:collapse;width:100%;font-size:13px}th{text-align:left;color:var(--dim);font-weight:600}
th,td{padding:4px 10px 4px 0;border-bottom:1px solid var(--hair);vertical-align:top}
td.t{white-space:nowrap;font-variant-numeric:tabular-nums;text-align:right;padding-right:14px}
tr.now td{border-top:2px solid var(--moment)}
.tag{display:inline-block;min-width:72px;font-size:11.5px;padding:0 7px;border-radius:9px;text-align:center;background:#f4f6f9;
border:1px solid var(--hair)}
.tag.mode{background:#dbeafe}.tag.cause,.tag.stop{background:#fee2e2}.tag.rule{background:#fef3c7}.tag.asked,.tag.request{background:#e0f2e9}
svg{display:block;width:100%;height:auto}svg text{font:11px system-ui,"DejaVu Sans",sans-serif;fill:var(--ink)}
svg .title{font-weight:600}svg .tick{text-anchor:middle;fill:var(--dim)}svg .value,svg .lane-name{text-anchor:end;fill:var(--dim)}
svg .lane-name{fill:var(--ink)}svg .legend{fill:var(--dim)}svg .nothing{fill:var(--dim);font-style:italic}
svg .bound-name{text-anchor:end;fill:var(--cause);font-size:10px}
.grid{stroke:var(--hair);stroke-width:1}.zero{stroke:#9aa5b4;stroke-width:1}.lane{stroke:var(--hair)}
.bound{stroke:var(--cause);stroke-dasharray:2 4}
.curve{fill:none;stroke-width:1.6;stroke-linejoin:round}.curve.asked{stroke:var(--asked);stroke-dasharray:5 3}
.curve.applied{stroke:var(--applied)}.curve.measured{stroke:var(--measured);stroke-width:1.2}.curve.picture{stroke:#0f766e}
.curve.speed{stroke:var(--ink)}.curve.limit{stroke:var(--cause);stroke-dasharray:8 3}
.moment{stroke:var(--moment);stroke-width:1.6}.moment-name{text-anchor:middle;font-weight:700;fill:var(--moment)!important}
.rule{fill:var(--rule)}.cause{fill:var(--cause)}.asked:not(.curve):not(.tag){fill:#0f766e}
.mode{stroke:#fff;stroke-width:1}.in-band{font-weight:600}
.standby{fill:#d6dbe3}.autonomous{fill:#bfdbfe}.takeover_requested{fill:#fde68a}.handing_over,.handing_back{fill:#ddd6fe}
.remote{fill:#a7e3c4}.local_driver{fill:#c7d2a0}.safe_stop{fill:#fca5a5}.stopped{fill:#e3b8b8}.emergency_stop{fill:#f87171}
.strip{display:grid;grid-template-columns:repeat(4,1fr);gap:10px}
figure{margin:0;border:1px solid var(--hair);border-radius:4px;overflow:hidden;break-inside:avoid;background:#f7f8fa}
figure.now{outline:3px solid var(--moment)}figure.old figcaption b{color:var(--cause)}
figure img{display:block;width:100%}
figure .none{display:flex;align-items:center;justify-content:center;aspect-ratio:16/9;color:var(--dim);font-style:italic;
font-size:13px;padding:0 14px;text-align:center}
figcaption{padding:5px 9px;font-size:12.5px;line-height:1.35;border-top:1px solid var(--hair)}
.views{display:grid;grid-template-columns:repeat(4,1fr);gap:12px}
.top-view{background:#e9ede6}.road{fill:#c9cdd3}.kerb{fill:none;stroke:#7c8594;stroke-width:1.5}
.centre{fill:none;stroke:#fff;stroke-width:1.5;stroke-dasharray:10 8}
.corridor{fill:none;stroke:#16a34a;stroke-opacity:.28}.plan{fill:none;stroke:#1d4ed8;stroke-width:2;stroke-dasharray:6 4}
.object{fill:#6b7280;stroke:#111}.object.person{fill:#dc2626}.object.cone{fill:#f97316}.object.barrier{fill:#7c2d12}.object.vehicle{fill:#4338ca}
.doubt{fill:#111;fill-opacity:.1}.moving{fill:none;stroke:#111;stroke-width:1.5}.place{fill:#fbbf24;stroke:#92400e}
svg .object-name{font-size:12px}.car{fill:#1f2937}.nose{fill:#fff}.scale{stroke:var(--ink);stroke-width:2}
@media print{body{background:#fff}main{padding:0;max-width:none}h2,h3{break-after:avoid}tr,figure,.at{break-inside:avoid}
.axis{max-height:17.5cm}}
@page{size:A4 landscape;margin:12mm}
"""
