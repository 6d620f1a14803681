asm update_for_equals
signature:
definitions:
  main rule r_Main =
    if a := 1 then b := 2 endif //~ L051
