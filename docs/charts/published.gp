# docs/published.md's chart: gnuplot docs/charts/published.gp > docs/charts/published.svg
set terminal svg size 760,400 font "sans-serif,13" background "white"
set xlabel "seconds of the whole run (wall clock)"
set ylabel "PSNR on the test views, dB"
set xrange [0:1500]
set yrange [34.6:36.5]
set grid lc rgb "#dddddd"
set border 3
set tics nomirror
set key bottom right
$ours << EOD
567 35.95 "18,000 steps"
636 36.00 "20,500 steps"
EOD
$before << EOD
1274 35.11 "30,000 steps, commit c963d26"
EOD
$published << EOD
720 35.98 "DCSH"
559 34.91 "Compact"
243 35.30 "DCSHARP"
EOD
plot $ours using 1:2 with linespoints pt 7 ps 0.9 lc rgb "#0072b2" title "CoSplat, two CPU cores", \
     $ours using 1:2:3 with labels left offset 0.8,0.7 tc rgb "#0072b2" notitle, \
     $before using 1:2 with points pt 7 ps 0.9 lc rgb "#999999" title "CoSplat before, two CPU cores", \
     $before using 1:2:3 with labels right offset -0.8,0 tc rgb "#777777" notitle, \
     $published using 1:2 with points pt 6 ps 0.9 lc rgb "#d55e00" title "published, an A6000", \
     $published using 1:2:3 with labels left offset 0.8,-0.3 tc rgb "#d55e00" notitle
