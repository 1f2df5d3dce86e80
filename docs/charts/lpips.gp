# docs/lpips.md's chart: gnuplot docs/charts/lpips.gp > docs/charts/lpips.svg
set terminal svg size 760,340 font "sans-serif,13" background "white"
set multiplot layout 1,2
set xlabel "PSNR on the held-out images, dB"
set grid lc rgb "#dddddd"
set border 3
set tics nomirror
unset key
$fox << EOD
32.22 0.0527 "0"
31.97 0.0442 "0.01"
32.11 0.0371 "0.05"
31.55 0.0338 "0.2"
EOD
$head << EOD
25.68 0.0683 "0"
25.52 0.0612 "0.01"
25.41 0.0568 "0.05"
25.03 0.0562 "0.2"
EOD
set yrange [0.030:0.057]
set xrange [31.4:32.5]
set title "fox, by weight"
set ylabel "LPIPS (SqueezeNet), smaller is better"
plot $fox using 1:2 with linespoints pt 7 ps 0.9 lc rgb "#0072b2", \
     $fox using 1:2:3 with labels left offset 0.8,0.5 tc rgb "#0072b2"
set yrange [0.053:0.071]
set xrange [24.9:26]
set title "head, by weight"
unset ylabel
plot $head using 1:2 with linespoints pt 7 ps 0.9 lc rgb "#d55e00", \
     $head using 1:2:3 with labels left offset 0.8,0.5 tc rgb "#d55e00"
unset multiplot
