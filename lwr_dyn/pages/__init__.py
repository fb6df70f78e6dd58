"""What people see in a browser or a notebook: replay, pictures, results.

document  A document as HTML: a page, one file that needs no network, or what a notebook shows in place of a result's
          text
explorer  An arm in the browser: sliders, frames, centres of mass, inertia ellipsoids, limits, and the source of each
          number
figures   What is drawn, described once for pages and pictures
markup    HTML from records: an element or a table at a time; text is escaped unless it is `Html` already
plotting  Figures as pictures: PNG and SVG by Matplotlib, and HTML
replay    Runs in 3D, as one file or live
still     A picture of an arm: its cylinders drawn by ray casting, with the paths of runs over them where that is
          asked
"""
