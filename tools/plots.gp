# gnuplot -e "data='FOLDER'; out='FOLDER'" plots.gp: response.png and angles.png from what furrow_figures wrote.

set terminal pngcairo size 1120,420 font "DejaVu Sans,11" linewidth 1.2
set border linewidth 0.8
set tics nomirror scale 0.6
set grid linecolor rgb "#d8d8d8" linewidth 0.5

# Larsson, figure 6.
set output out."/response.png"
set multiplot layout 1,2 margins 0.065,0.985,0.14,0.9 spacing 0.085
set xrange [0.5:3]
set yrange [0:1]
set xtics 0.5
set ytics 0.2
set xlabel "compression factor α = L² / l²"
set ylabel "intensity I(α)" offset 1
set key bottom right Left reverse samplen 2.4 spacing 1.2 box linecolor rgb "#d8d8d8" opaque
set arrow 1 from 1,0 to 1,1 nohead dashtype (3,3) linecolor rgb "#909090"
set title "β = 4"
plot data."/response.dat" using 1:2 with lines linewidth 2 linecolor rgb "#d95f02" title "λ = 0.8", \
     "" using 1:3 with lines linewidth 2 linecolor rgb "#222222" title "λ = 1", \
     "" using 1:4 with lines linewidth 2 linecolor rgb "#1f78b4" title "λ = 1.25"
set title "λ = 1"
plot data."/response.dat" using 1:5 with lines linewidth 2 linecolor rgb "#1f78b4" title "β = 2", \
     "" using 1:3 with lines linewidth 2 linecolor rgb "#222222" title "β = 4", \
     "" using 1:6 with lines linewidth 2 linecolor rgb "#d95f02" title "β = 8"
unset multiplot
unset arrow 1

# Larsson, figure 21.
set output out."/angles.png"
set multiplot layout 1,2 margins 0.075,0.985,0.14,0.9 spacing 0.135
set title "angle between exact and z-only normalisation [degrees]"
set xlabel "intensity I"
set ylabel "x² + y² of the map's normal" offset 0
set xrange [0:1]
set yrange [0:0.9]
set xtics 0.2
set ytics 0.1
set cbrange [0:28]
set cbtics 0,4,28
set palette defined (0 "#ffffff", 4 "#fee8c8", 10 "#fdbb84", 18 "#e34a33", 28 "#7f0000")
set view map
set contour base
set cntrparam levels discrete 1, 2, 4, 6, 8, 10, 15, 20
set cntrlabel onecolor font ",9" start 40 interval 1000
unset key
splot data."/angles.dat" using 2:1:3 with pm3d nocontour, \
      "" using 2:1:3 with lines nosurface linecolor rgb "#333333" linewidth 0.8, \
      "" using 2:1:3 with labels nosurface
unset contour
unset colorbox
unset view
set title "largest over I"
set xlabel "x² + y² of the map's normal"
set ylabel "degrees" offset 1
set xrange [0:0.9]
set yrange [0:30]
set xtics 0.1
set ytics 5
array Largest[91]
do for [row=0:90] {
  stats data."/angles.dat" every :::row::row using 3 nooutput
  Largest[row+1] = STATS_max
}
set label 1 sprintf("%.2f° at 0.60", Largest[61]) at 0.6,Largest[61] point pointtype 7 pointsize 0.9 offset -12,0.9
set label 2 sprintf("%.2f° at 0.64", Largest[65]) at 0.64,Largest[65] point pointtype 7 pointsize 0.9 offset -12,0.9
plot Largest using (0.01*($1-1)):2 with lines linewidth 2 linecolor rgb "#222222"
unset multiplot
