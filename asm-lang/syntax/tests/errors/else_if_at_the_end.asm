asm else_if_at_the_end
signature:
definitions:
  main rule r_Main =
    if a = 1 then b := 1
    else if a = 2 then b := 2
    endif //~ L032
