asm unneeded_end
signature:
definitions:
  rule r_a =
    par
      choose $x in d with f($x) do
        a := $x
      endchoose //~ L064
      forall $x in d do b($x) := 1 endforall //~ L064
      extend D with $y do skip endextend //~ L064
    endpar
  rule r_b = forall $x in d do
    skip
  endforall //~ L064
  main rule r_Main = while a do seq skip skip endseq endwhile //~ L064
