"""A report as one HTML file that loads nothing and can be read without a script.

blocks       Numbers, errata, checks, sections and files of a report as HTML that is readable without scripts
content      The content of a report page as plain records, without HTML
figure_html  A figure as HTML: a grid of small panels, each with its own axes; lines are SVG, every text is text of
             the page
page         A report as one HTML file: text, tables and figures are HTML and SVG; scripts add the 3D replay, cursors
             and zoom
still_image  A still of the 3D view before it starts, under the paths of the runs as SVG in their colours; the runs in
             numbers
"""
