asm call_without_brackets
signature:
definitions:
  main rule r_Main =
    par
      r_a //~ L037
      r_b[]
    endpar
