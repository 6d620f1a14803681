asm elsif
signature:
definitions:
  rule r_a =
    if a = 1 then b := 1
    elsif a = 2 then b := 2 //~ L009
    endif
  main rule r_Main = skip //~ L032
