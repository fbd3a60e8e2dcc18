"""How the report looks: light, dark, narrow and printed, with nothing from anywhere else."""

STYLE = """
:root{color-scheme:light dark;--paper:#fff;--ink:#1a2230;--soft:#556070;--line:#d9dfe8;
--wash:#f4f6f9;--link:#0b5cad;--good:#12683a;--good-wash:#dcf3e4;--bad:#a1221a;--bad-wash:#fbe3e0;
--warn:#7a4d00;--warn-wash:#fdf0cf}
@media(prefers-color-scheme:dark){:root{--paper:#10151c;--ink:#dfe5ee;--soft:#9aa7b8;--line:#2b3543;
--wash:#18202b;--link:#79b8ff;--good:#7fdba1;--good-wash:#12301f;--bad:#ff9d94;--bad-wash:#3a1714;
--warn:#f5cf7a;--warn-wash:#352707}}
*{box-sizing:border-box}
body{font:16px/1.5 system-ui,-apple-system,"Segoe UI",sans-serif;margin:0;background:var(--paper);
color:var(--ink)}
main{max-width:68rem;margin:0 auto;padding:2rem 1.25rem 4rem}
h1{font-size:1.75rem;line-height:1.2;margin:0 0 .25rem}
h2{font-size:1.2rem;margin:2.5rem 0 .6rem;padding-top:.9rem;border-top:1px solid var(--line)}
h3{font-size:1rem;margin:1.4rem 0 .4rem}
p{margin:.4rem 0 .8rem;max-width:46rem}
a{color:var(--link)}
.soft,caption,dt{color:var(--soft)}
.fate{display:inline-block;padding:.15rem .75rem;border-radius:1rem;font-weight:600;
background:var(--wash);color:var(--ink)}
.succeeded{background:var(--good-wash);color:var(--good)}
.failed{background:var(--bad-wash);color:var(--bad)}
.aborted,.interrupted,.running{background:var(--warn-wash);color:var(--warn)}
.verdict{font-size:1.1rem;margin:.8rem 0}
.caution{border-left:4px solid var(--warn);background:var(--warn-wash);padding:.6rem .9rem;
margin:1rem 0}
.caution p,.caution ul{margin:.2rem 0}
nav ul{display:flex;flex-wrap:wrap;gap:.2rem 1.1rem;list-style:none;margin:1rem 0 0;padding:0;
font-size:.9rem}
dl{display:grid;grid-template-columns:repeat(auto-fit,minmax(13rem,1fr));gap:.7rem 1.5rem;
margin:1rem 0;padding:.9rem 1rem;background:var(--wash);border-radius:.5rem}
dt{font-size:.8rem}dd{margin:0;overflow-wrap:anywhere}
.scroll{overflow-x:auto;margin:.6rem 0 1.2rem}
.scroll:focus-visible{outline:2px solid var(--link);outline-offset:2px}
table{border-collapse:collapse;font-size:.875rem;min-width:min(100%,42rem)}
caption{text-align:left;padding:0 0 .3rem;font-size:.85rem}
th,td{padding:.3rem .8rem .3rem 0;text-align:left;vertical-align:top;
border-bottom:1px solid var(--line)}
thead th{font-weight:600;white-space:nowrap}tbody th{font-weight:400}
.name{white-space:nowrap}
td:not(.number){min-width:7rem}
.number{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
.when{white-space:nowrap;font-variant-numeric:tabular-nums}
code,pre{font:.82em/1.5 ui-monospace,SFMono-Regular,Menlo,Consolas,monospace}
code{overflow-wrap:anywhere}
pre{overflow-x:auto;padding:.8rem 1rem;background:var(--wash);border-radius:.5rem;max-height:30rem}
.hash{word-break:break-all;min-width:20rem;display:inline-block}
td ul,td ol{margin:0;padding-left:1.1rem}
.bad{color:var(--bad);font-weight:600}.good{color:var(--good)}.warn{color:var(--warn);font-weight:600}
details{margin:.6rem 0}summary{cursor:pointer;color:var(--link)}
figure{margin:1rem 0}figcaption{color:var(--soft);font-size:.85rem}
img{max-width:100%;height:auto;background:#fff;border-radius:.4rem}
.bar{display:flex;height:1.1rem;border-radius:.3rem;overflow:hidden;margin:.6rem 0 .2rem;
border:1px solid var(--line)}
.bar span{min-width:2px}.bar .ran{background:#3f8f63}.bar .away{background:#c8504a}
.gantt{display:block;width:100%;min-width:24rem;height:1.1rem;background:var(--wash);fill:#2f7fb8}
.axis{position:relative;height:1.2em}.axis span{position:absolute;white-space:nowrap}
@media print{:root{color-scheme:light;--paper:#fff;--ink:#000;--soft:#444;--line:#bbb;--wash:#fff;
--link:#000;--good:#000;--bad:#000;--warn:#000;--good-wash:#fff;--bad-wash:#fff;--warn-wash:#fff}
body{font-size:10pt}main{max-width:none;padding:0}nav{display:none}.scroll{overflow:visible}
.fate,.caution,dl{border:1px solid #888}pre{max-height:none;white-space:pre-wrap}
h2,h3,caption{break-after:avoid}tr,figure,dl{break-inside:avoid}thead{display:table-header-group}
.bar{display:none}}
"""
