"""Completion for bash, zsh and fish: subcommands, options, the words that an option takes, and files where it takes files."""

import re

NOTE = "# Made by tools/make_manual.py of the programs' own tables of options.\n"
DISPATCHER = {"help": "print what a subcommand does", "--help": "list the subcommands", "--version": "print the version"}
HELP = ("-h", "--help", "print this, and end")


def takes_files(option):
    """Values such as YYYY-MM-DD=FILE and MODEL.fls@LAT,LON hold a file's name, too."""
    return option["type"] == "file" or (option["type"] == "text" and re.search(r"FILE|\.fls\b", option["value"]) is not None)


def suffixes(option):
    """What the name of the value says of its files: `fls` of SCENE.fls."""
    return re.findall(r"\.([a-z]+)", option["value"])


def brief(option):
    """The first sentence, of what fits beside an option."""
    text = re.split(r"; |\. ", option["description"].replace("`", ""))[0]
    return text if len(text) <= 90 else text[:text.rfind(" ", 0, 88)] + " ..."


def path_of(program):
    """`bench load` of `foreland bench load`."""
    return program.name.split(" ", 1)[1]


def every(programs):
    for program in programs.all:
        yield from program.all()


# ---- bash

BASH = r"""# bash completion for foreland                             -*- shell-script -*-
@NOTE@
# Sets `options` of a subcommand, and `once`, those of them that may be given only once.
_foreland_options() {
  case "$1" in
@OPTIONS@
    *) options="-h --help" once="" ;;
  esac
}

# Sets what an option of a subcommand takes, or the words that are no option: `words`, which `delimiter` may stand between, or
# `files` with one of some `suffixes`, or `folders`. All are empty for other texts. Fails if the option takes no value.
_foreland_value() {
  words="" delimiter="" kind="text" suffixes=""
  case "$1" in
@VALUES@
    *) return 1 ;;
  esac
}

_foreland_files() {
  local suffix all=()
  compopt -o filenames 2>/dev/null
  for suffix in $suffixes; do mapfile -t -O "${#all[@]}" all < <(compgen -f -X "!*.$suffix" -- "$word"); done
  [[ -z "$suffixes" || ${#all[@]} -eq 0 ]] && mapfile -t all < <(compgen -f -- "$word")
  mapfile -t -O "${#all[@]}" all < <(compgen -d -- "$word")
  [[ ${#all[@]} -eq 0 ]] || mapfile -t COMPREPLY < <(printf '%s\n' "${all[@]}" | sort -u)
}

_foreland_complete_value() {
  case "$kind" in
    words)
      local before=""
      [[ -n "$delimiter" && "$word" == *"$delimiter"* ]] && before="${word%"$delimiter"*}$delimiter"
      mapfile -t COMPREPLY < <(compgen -P "$before" -W "$words" -- "${word#"$before"}")
      ;;
    files) _foreland_files ;;
    folders) compopt -o filenames 2>/dev/null; mapfile -t COMPREPLY < <(compgen -d -- "$word") ;;
  esac
}

# The options that are still worth giving.
_foreland_complete_option() {
  local options once given left="" option
  _foreland_options "$path"
  given=" ${COMP_WORDS[*]:begin:COMP_CWORD-begin} "
  for option in $options; do
    [[ " $once " == *" $option "* && "$given" == *" $option "* ]] || left+=" $option"
  done
  mapfile -t COMPREPLY < <(compgen -W "$left" -- "$word")
}

_foreland() {
  local word="${COMP_WORDS[COMP_CWORD]}" before="" path="" begin=1 words delimiter kind suffixes index
  COMPREPLY=()
  [[ $COMP_CWORD -gt 0 ]] && before="${COMP_WORDS[COMP_CWORD-1]}"
  case "${COMP_WORDS[0]##*/}" in
    foreland-*) path="${COMP_WORDS[0]##*/foreland-}"; path="${path#foreland-}" ;;
    *)
      if [[ $COMP_CWORD -eq 1 ]]; then
        mapfile -t COMPREPLY < <(compgen -W "@SUBCOMMANDS@ @DISPATCHER@" -- "$word")
        return
      fi
      path="${COMP_WORDS[1]}" begin=2
      ;;
  esac
  if [[ "$path" == help ]]; then
    mapfile -t COMPREPLY < <(compgen -W "@SUBCOMMANDS@" -- "$word")
    return
  fi
@NESTED@
  # --option=value comes as three words, where = is a break between words.
  if [[ "$word" == "=" ]]; then
    word=""
  elif [[ "$before" == "=" && $COMP_CWORD -gt 1 ]]; then
    before="${COMP_WORDS[COMP_CWORD-2]}"
  fi
  if [[ "$before" == -* ]] && _foreland_value "$path $before"; then
    _foreland_complete_value
  elif [[ "$word" == -* ]]; then
    _foreland_complete_option
  elif _foreland_value "$path"; then
    _foreland_complete_value
  fi
}

complete -F _foreland foreland @COMMANDS@
"""

NESTED = r"""  if [[ "$path" == @NAME@ ]]; then
    for ((index = begin; index < COMP_CWORD; index++)); do
      [[ " @SUBS@ " == *" ${COMP_WORDS[index]} "* ]] && path="@NAME@ ${COMP_WORDS[index]}" && break
    done
    if [[ "$path" == @NAME@ && "$word" != -* ]]; then
      mapfile -t COMPREPLY < <(compgen -W "@SUBS@" -- "$word")
      return
    fi
  fi"""


def filled(template, **values):
    for name, value in values.items():
        template = template.replace(f"@{name}@", value)
    return template


def bash_value(option):
    if option.get("words"):
        delimiter = f' delimiter="{option["delimiter"]}"' if "delimiter" in option else ""
        return f'kind="words" words="{" ".join(option["words"])}"{delimiter}'
    if takes_files(option):
        return f'kind="files" suffixes="{" ".join(suffixes(option))}"'
    return 'kind="folders"' if option["type"] == "folder" else 'kind="text"'


def bash_subcommand(program):
    """The two cases of a subcommand."""
    path = path_of(program)
    names = [name for o in program.named() for name in o["names"]] + list(HELP[:2])
    once = [name for o in program.named() if not o["repeatable"] for name in o["names"]]
    options = f'    "{path}") options="{" ".join(names)}" once="{" ".join(once)}" ;;'
    values = [f'    {" | ".join(f"{chr(34)}{path} {name}{chr(34)}" for name in o["names"])}) {bash_value(o)} ;;'
              for o in program.named() if o["type"] != "flag"]
    values += [f'    "{path}") {bash_value(o)} ;;' for o in program.positional()[:1]]
    return options, "\n".join(values)


def bash(programs):
    cases = [bash_subcommand(program) for program in every(programs)]
    nested = [filled(NESTED, NAME=p.word, SUBS=" ".join(s.word for s in p.subcommands)) for p in programs.all if p.subcommands]
    words = [p.word for p in programs.all]
    return filled(BASH, NOTE=NOTE, OPTIONS="\n".join(c[0] for c in cases), VALUES="\n".join(c[1] for c in cases if c[1]),
                  NESTED="\n".join(nested), SUBCOMMANDS=" ".join(words), DISPATCHER=" ".join(DISPATCHER),
                  COMMANDS=" ".join("foreland-" + word for word in words))


# ---- zsh

ZSH = r"""#compdef foreland @COMMANDS@
@NOTE@
@FUNCTIONS@
_foreland() {
  local curcontext="$curcontext" state line
  local -a subcommands
  subcommands=(
@SUBCOMMANDS@
  )
  if [[ "$service" == foreland-* ]]; then
    _foreland_${service#foreland-}
    return
  fi
  _arguments -C '(- *)'{-h,--help}'[list the subcommands]' '(- *)--version[print the version]' \
    '1: :->subcommand' '*:: :->argument' && return
  case "$state" in
    subcommand) _describe -t subcommands subcommand subcommands -- "(help:'print what a subcommand does')" ;;
    argument)
      if [[ "$words[1]" == help ]]; then
        _describe -t subcommands subcommand subcommands
      elif (( $+functions[_foreland_$words[1]] )); then
        _foreland_$words[1]
      fi
      ;;
  esac
}

_foreland "$@"
"""


def quoted(text):
    return "'" + text.replace("'", "'\\''") + "'"


def zsh_text(text):
    """For a part of a specification of _arguments."""
    return re.sub(r"([\[\]:\\])", r"\\\1", text)


def zsh_action(option):
    if option.get("words"):
        words = " ".join(option["words"])
        return f"_values -s {option['delimiter']} word {words}" if "delimiter" in option else f"({words})"
    if takes_files(option):
        found = suffixes(option)
        return "_files" + (f' -g "*.({"|".join(found)})(-.)"' if found and option["type"] == "file" else "")
    return "_files -/" if option["type"] == "folder" else " "


def zsh_option(option):
    names, repeated = option["names"], "*" if option["repeatable"] else ""
    barred = list(option.get("excludes", [])) + ([] if repeated else names if len(names) > 1 else [])
    value = "" if option["type"] == "flag" else f":{zsh_text(option['value'])}:{zsh_action(option)}"
    about = f"[{zsh_text(brief(option))}]{value}"
    shown = []
    for name in names:
        sign = name if not value else name + ("=" if name.startswith("--") else "+")
        shown.append(quoted((f"({' '.join(barred)})" if barred else "") + repeated + sign + about))
    return shown


def zsh_positional(option, number):
    where = "*" if option["repeatable"] else str(number)
    return quoted(f"{where}:{zsh_text(option['names'][0])}:{zsh_action(option)}")


def zsh_function(program):
    name = "_foreland_" + "_".join(path_of(program).split())
    specs = [spec for o in program.named() for spec in zsh_option(o)]
    specs.append(quoted(f"(- *)-h[{HELP[2]}]"))
    specs.append(quoted(f"(- *)--help[{HELP[2]}]"))
    if not program.subcommands:
        specs += [zsh_positional(o, n + 1) for n, o in enumerate(program.positional())]
        body = "  _arguments -s -S \\\n    " + " \\\n    ".join(specs)
        return f"{name}() {{\n{body}\n}}\n"
    subs = "\n".join("    " + quoted(f"{s.word}:{s.short}") for s in program.subcommands)
    return f"""{name}() {{
  local curcontext="$curcontext" state line
  local -a subcommands
  subcommands=(
{subs}
  )
  _arguments -C {' '.join(specs)} '1: :->subcommand' '*:: :->argument' && return
  case "$state" in
    subcommand) _describe -t subcommands subcommand subcommands ;;
    argument) (( $+functions[{name}_$words[1]] )) && {name}_$words[1] ;;
  esac
}}
"""


def zsh(programs):
    subcommands = "\n".join("    " + quoted(f"{p.word}:{p.short}") for p in programs.all)
    return filled(ZSH, NOTE=NOTE, COMMANDS=" ".join("foreland-" + p.word for p in programs.all),
                  FUNCTIONS="\n".join(zsh_function(p) for p in every(programs)), SUBCOMMANDS=subcommands)


# ---- fish

FISH = r"""# fish completion for foreland
@NOTE@
# Whether the command line has come to this subcommand, and to the one below it, if that is given.
function __foreland_is
    set -l words (commandline -opc)
    test (count $words) -ge 2; and test "$words[2]" = "$argv[1]"; or return 1
    test (count $argv) -lt 2; or contains -- $argv[2] $words[3..-1]
end

# Whether it has come to a subcommand that has others below it, but to none of these.
function __foreland_lacks
    __foreland_is $argv[1]; or return 1
    set -l words (commandline -opc)
    for word in $argv[2..-1]
        contains -- $word $words[3..-1]; and return 1
    end
    return 0
end

function __foreland_lacks_all
    test (count (commandline -opc)) -eq 1
end

complete -c foreland -f
complete -c foreland -n __foreland_lacks_all -s h -l help -d 'list the subcommands'
complete -c foreland -n __foreland_lacks_all -l version -d 'print the version'
complete -c foreland -n __foreland_lacks_all -a help -d 'print what a subcommand does'
complete -c foreland -n '__foreland_is help' -a '@SUBCOMMANDS@'
"""


def fish_quoted(text):
    return "'" + text.replace("\\", "\\\\").replace("'", "\\'") + "'"


def fish_value(option):
    """How the value is completed."""
    if option["type"] == "flag":
        return ""
    if option.get("words"):
        words = " ".join(option["words"])
        if "delimiter" in option:
            return f" -x -a {fish_quoted('(__fish_append ' + option['delimiter'] + ' ' + words + ')')}"
        return f" -x -a {fish_quoted(words)}"
    if takes_files(option):
        found = suffixes(option) if option["type"] == "file" else []
        if found:
            return " -k -x -a " + fish_quoted(f"(__fish_complete_suffix {' '.join('.' + f for f in found)})")
        return " -r -F"
    return " -x -a '(__fish_complete_directories)'" if option["type"] == "folder" else " -x"


def fish_lines(program):
    path = path_of(program)
    begin = f"complete -c foreland -n '__foreland_is {path}'"
    for option in program.named():
        signs = "".join(f" -{'l' if n.startswith('--') else 's'} {n.lstrip('-')}" for n in option["names"])
        yield f"{begin}{signs}{fish_value(option)} -d {fish_quoted(brief(option))}"
    yield f"{begin} -s h -l help -d {fish_quoted(HELP[2])}"
    for option in program.positional()[:1]:
        if takes_files(option) or option["type"] == "folder":
            value = fish_value(option).replace(" -x ", " ", 1).replace(" -r", "", 1)
            yield begin + value
    if program.subcommands:
        words = " ".join(s.word for s in program.subcommands)
        for sub in program.subcommands:
            yield f"complete -c foreland -n '__foreland_lacks {path} {words}' -a {sub.word} -d {fish_quoted(sub.short)}"


def fish(programs):
    out = filled(FISH, NOTE=NOTE, SUBCOMMANDS=" ".join(p.word for p in programs.all))
    for program in programs.all:
        out += f"complete -c foreland -n __foreland_lacks_all -a {program.word} -d {fish_quoted(program.short)}\n"
    for program in every(programs):
        out += "\n" + "\n".join(fish_lines(program)) + "\n"
    return out
