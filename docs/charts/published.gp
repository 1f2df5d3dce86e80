# The chart of README.md and docs/published.md: gnuplot docs/charts/published.gp > docs/charts/published.svg
# A mark's area grows with the number of Gaussians.
set terminal svg size 760,400 font "sans-serif,13" background "white"
set title "Chair of Synthetic-NeRF, 800×800"
set xlabel "seconds of the whole training (wall clock, logarithmic)"
set ylabel "PSNR on the test views, dB"
set logscale x
set xrange [12:4500]
set yrange [34.6:36.8]
set xtics (15, 30, 60, 120, 300, 600, 1200, 2400)
set grid lc rgb "#dddddd"
set border 3
set tics nomirror
set key bottom left
size(n) = sqrt(n / 60000.0)
$cores << EOD
289 36.10 114788 "12,000 steps"
314 36.09 56700 "15,000, pruned to 56,700"
963 36.48 172869 "30,000 steps"
EOD
$gpu << EOD
21.3 36.11 56700 "pruned to 56,700"
24.5 36.22 154306 "30,000 steps, 154,306 Gaussians"
EOD
$published << EOD
720 35.98 419901 "DCSH, 419,901"
559 34.91 153570 "Compact"
243 35.30 56700 "DCSHARP, 56,700"
EOD
plot $gpu using 1:2:(size($3)) with points pt 7 ps variable lc rgb "#009e73" title "CoSplat, an H100", \
     $gpu using 1:($2 + ($3 < 1e5 ? -0.1 : 0.1)):4 with labels left offset -0.6,0 tc rgb "#009e73" notitle, \
     $cores using 1:2:(size($3)) with points pt 7 ps variable lc rgb "#0072b2" title "CoSplat, two CPU cores", \
     $cores using 1:($2 + ($1 == 314 ? -0.16 : 0.14)):4 with labels right offset 2,0 tc rgb "#0072b2" notitle, \
     $published using 1:2:(size($3)) with points pt 6 lw 2 ps variable lc rgb "#d55e00" title "published, an A6000", \
     $published using 1:2:4 with labels left offset 1.6,-0.8 tc rgb "#d55e00" notitle
