!> The command line: tables of commands and options, and the parser of the arguments.
module nutate_cli
   use nutate_aem_writing, only: aem_versions
   use nutate_gnuplot, only: is_picture
   use nutate_kinds, only: long, wp
   use nutate_number_text, only: read_real
   use nutate_printable, only: printable_path, quoted
   use nutate_scene_error, only: PLACE_OF_SET, PLACE_OF_UNSET
   use nutate_spelling, only: comma_list, is_listed, nearest_name, split_list
   implicit none
   private

   public :: did_you_mean, naming_options, argument_t, command_t, option_t, verb_t, options, verbs, get_arguments, &
             parse_arguments

   !> One word of the command line.
   type :: argument_t
      character(len=:), allocatable :: text
   end type argument_t

   !> One command.
   type :: verb_t
      character(len=9) :: name
      !> Purpose of the command, in one line.
      character(len=100) :: purpose
      !> Argument of the command, as the help names it.
      character(len=12) :: object = 'SCENE'
   end type verb_t

   !> All commands.
   type(verb_t), parameter :: verbs(*) = [ &
      verb_t('run', 'simulate a scene and write its history as CSV'), &
      verb_t('check', 'validate a scene and print a summary (dry run)'), &
      verb_t('cost', 'work-precision study: run time against error for every method'), &
      verb_t('sweep', 'run an ensemble (Monte Carlo or parameter sweep); one result row per member'), &
      verb_t('fit', 'fit a scene to measurements; standard errors, residuals, fitted scene'), &
      verb_t('linearize', 'linearise at an equilibrium or over a period: A, B, eigenvalues; find equilibria'), &
      verb_t('plot', 'plot a time history with gnuplot', 'HISTORY.csv'), &
      verb_t('export', 'write a time history for other programs: AEM (CCSDS), glTF', 'HISTORY.csv'), &
      verb_t('view', 'run a scene and write a web page with a 3-D animation (needs Python)')]

   !> One option.
   type :: option_t
      character(len=16) :: name
      !> Placeholder of the value; blank for an option without value.
      character(len=16) :: value
      !> Commands that accept the option, comma separated; blank for an option that needs no command.
      character(len=64) :: verbs
      character(len=100) :: purpose
   end type option_t

   !> All options.
   type(option_t), parameter :: options(*) = [ &
      option_t('--output', 'FILE', 'run', &
               'history, or -o FILE; - is standard output (default: named by the scene)'), &
      option_t('--output', 'FILE', 'plot', 'picture, or -o FILE (default: HISTORY.svg)'), &
      option_t('--output', 'FILE', 'view', 'web page, or -o FILE (default: SCENE.html)'), &
      option_t('--output', 'FILE', 'sweep', 'result rows, or -o FILE (default: SCENE.npy)'), &
      option_t('--output', 'FILE', 'fit', 'fitted scene, or -o FILE (default: SCENE.fit.nml)'), &
      option_t('--members', 'A:B', 'sweep', 'run members A to B only and write them to a separate file'), &
      option_t('--member', 'K', 'sweep', &
      'run member K only, with its history; its result row goes to standard output'), &
      option_t('--threads', 'N', 'sweep', 'number of members to run in parallel (default: 1)'), &
      option_t('--merge', '', 'sweep', 'merge the files written with --members'), &
      option_t('--set', 'GROUP.KEY=VALUE', 'run,check,cost,view,sweep,export,fit,linearize', &
               'override a value of the scene; may be repeated'), &
      option_t('--unset', 'GROUP.KEY', 'run,check,cost,view,sweep,export,fit,linearize', &
               'remove a key from the scene; may be repeated'), &
      option_t('--plot', 'FILE.svg|png|pdf', 'run', 'plot the history with gnuplot'), &
      option_t('--plot', 'FILE.svg|png|pdf', 'cost', 'plot error against run time with gnuplot'), &
      option_t('--plot', 'FILE.svg|png|pdf', 'fit', 'plot data, model and residuals with gnuplot'), &
      option_t('--columns', 'NAME,...', 'run,plot', &
               'columns or sets to plot, such as energy,omega3 (default: all but residuals)'), &
      option_t('--residuals', '', 'run,plot', 'plot the errors of energy, norm and orthogonality, too'), &
      option_t('--xy', 'NAME:NAME', 'run,plot', 'plot one column against another, such as omega1:omega2'), &
      option_t('--path', '1|2|3|-1|-2|-3', 'run,plot', &
               'plot the path of a body axis on the unit sphere, from above'), &
      option_t('--from', 'T', 'view', 'first time that is animated, s (default: the start of the motion)'), &
      option_t('--title', 'TEXT', 'run,plot', &
      'title of the plot (default: the title of the scene or the name of the history)'), &
      option_t('--all', '', 'cost', 'plot all methods with --plot (default: six)'), &
      option_t('--csv', 'FILE', 'cost', 'write one CSV row per run; - is standard output'), &
      option_t('--csv', 'FILE', 'sweep', 'write one CSV row per member, too; - is standard output'), &
      option_t('--csv', 'FILE', 'fit', 'residuals; - is standard output (default: SCENE.residuals.csv)'), &
      option_t('--seconds', 'N', 'cost', 'time budget in seconds (default: 20)'), &
      option_t('--evaluations', 'N', 'cost', &
               'budget in evaluations of the equations instead of seconds'), &
      option_t('--quiet', '', 'run,sweep,fit,linearize', 'no progress bar and no summary; errors are still printed'), &
      option_t('--max-steps', 'N', 'run', 'stop with exit status 3 after N steps'), &
      option_t('--max-steps', 'N', 'sweep', 'end a member that needs more than N steps; its row has status 9'), &
      option_t('--max-steps', 'N', 'fit', 'stop with exit status 3 after N steps of all runs together'), &
      option_t('--max-steps', 'N', 'linearize', 'stop with exit status 3 after N steps of the period'), &
      option_t('--max-rows', 'N', 'run', 'stop with exit status 3 after N rows of the history or of the events'), &
      option_t('--max-rows', 'N', 'sweep', 'reject a sweep of more than N members'), &
      option_t('--period', 'T|orbit', 'linearize', &
               'linearise over a period of T seconds, or of the orbit (default: an equilibrium)'), &
      option_t('--relative-rates', '', 'linearize', 'rates relative to axes that rotate with the equilibrium'), &
      option_t('--equilibria', '', 'linearize', 'find all (relative) equilibrium attitudes and their stability'), &
      option_t('--json', 'FILE', 'linearize', 'write the results as JSON, with all digits; - is standard output'), &
      option_t('--checkpoint', 'FILE', 'run', 'write checkpoints to FILE, so that an interrupted run can be resumed'), &
      option_t('--every-seconds', 'N', 'run', 'interval between checkpoints in seconds (default: 60)'), &
      option_t('--resume', 'FILE', 'run', 'resume the interrupted run of a checkpoint'), &
      option_t('--resume', '', 'sweep', 'resume an interrupted sweep, if there is one'), &
      option_t('--scene', 'SCENE', 'export', 'scene of the history: its epoch, names, frame and body'), &
      option_t('--aem', 'FILE', 'export', 'write an Attitude Ephemeris Message (CCSDS 504.0-B)'), &
      option_t('--aem-version', '2.0|1.0', 'export', 'version of the message (default: 2.0)'), &
      option_t('--gltf', 'FILE', 'export', 'write an animated body as glTF 2.0'), &
      option_t('--speed', 'X', 'export', 'simulated seconds per second of animation (default: 1)'), &
      option_t('--error', 'RAD', 'export', &
               'select rows so that interpolation stays within this error'), &
      option_t('--help', '', 'run,check,cost,plot,view,sweep,export,fit,linearize', 'show this help'), &
      option_t('--version', '', '', 'show the version')]

   !> Parsed arguments of the command line.
   type :: command_t
      !> Name of a command, `help` or `version`; blank if there are no arguments.
      character(len=9) :: verb = ''
      !> Command that the requested help describes; blank for the program.
      character(len=9) :: topic = ''
      character(len=:), allocatable :: scene
      !> Path of the output; not allocated if the scene decides.
      character(len=:), allocatable :: output
      !> Overrides `GROUP.KEY=VALUE` and `-GROUP.KEY`, in order; shape (number of overrides).
      character(len=:), allocatable :: overrides(:)
      logical :: quiet = .false.
      !> Limits of steps, and of rows in a file.
      integer(long) :: max_steps = huge(1_long), max_rows = huge(1_long)
      !> First and last member of a sweep (0: all), and the member to run alone (0: none).
      integer(long) :: first = 0, last = 0, member = 0
      integer :: threads = 1
      !> True if a sweep is resumed; true if the files of its parts are merged.
      logical :: goes_on = .false., merges = .false.
      !> Checkpoint to write, and checkpoint to resume from; not allocated if not requested.
      character(len=:), allocatable :: checkpoint, resume
      !> Time between checkpoints, s.
      real(wp) :: every_seconds = 60.0_wp
      !> Paths of the picture and of the CSV file; not allocated if not requested.
      character(len=:), allocatable :: plot, csv
      !> Columns to draw, comma separated, the two columns of an x-y plot, `NAME:NAME`, and the title of the picture;
      !> not allocated if not given.
      character(len=:), allocatable :: columns, xy, title
      !> True if the picture shows the errors of the integration; body axis whose path is drawn, 0: none.
      logical :: residuals = .false.
      integer :: path = 0
      !> First time of an animation, s, as given; not allocated for the start.
      character(len=:), allocatable :: begin
      !> True if the picture of a work-precision study shows every method.
      logical :: draws_all = .false.
      !> Budget of a work-precision study, s or evaluations of the equations; 0 evaluations: the time.
      real(wp) :: seconds = 20.0_wp
      integer(long) :: evaluations = 0
      !> Scene of a history, and the files to export it to; not allocated if not requested.
      character(len=:), allocatable :: of_scene, aem, gltf
      character(len=3) :: aem_version = '2.0'
      !> Attitude error between exported rows, rad (0: the rows of the history); speed of the animation over the motion.
      real(wp) :: error_between = 0.0_wp, speed = 1.0_wp
      !> Period to linearise over, s; 0: none; negative: the period of the orbit.
      real(wp) :: period = 0.0_wp
      !> True if equilibria are to be found.
      logical :: equilibria = .false.
      !> True if the states have relative rates.
      logical :: relative_rates = .false.
      !> Path of the JSON file; not allocated if not requested.
      character(len=:), allocatable :: json
      !> First error in the arguments; not allocated if there is none.
      character(len=:), allocatable :: error
   end type command_t

contains

   !> Returns a message about an override with the option of the command line; returns other messages unchanged.
   pure function naming_options(message) result(text)
      character(len=*), intent(in) :: message
      character(len=:), allocatable :: text
      text = message
      if (index(message, PLACE_OF_SET) == 1) text = '--set: '//message(len(PLACE_OF_SET) + 1:)
      if (index(message, PLACE_OF_UNSET) == 1) text = '--unset: '//message(len(PLACE_OF_UNSET) + 1:)
   end function naming_options

   !> Returns `did you mean FILE.nml?` if a file does not exist but the one with the ending does; else empty.
   function did_you_mean(path, ending) result(text)
      character(len=*), intent(in) :: path
      !> Ending of file names, with its dot.
      character(len=*), intent(in) :: ending
      character(len=:), allocatable :: text
      logical :: exists
      text = ''
      inquire (file=path, exist=exists)
      if (path == '' .or. exists) return
      inquire (file=path//ending, exist=exists)
      if (exists) text = 'did you mean '//printable_path(path//ending)//'?'
   end function did_you_mean

   !> Returns the arguments of the program.
   subroutine get_arguments(arguments)
      type(argument_t), allocatable, intent(out) :: arguments(:)
      integer :: i, length
      allocate (arguments(command_argument_count()))
      do i = 1, size(arguments)
         call get_command_argument(i, length=length)
         allocate (character(len=length) :: arguments(i)%text)
         if (length > 0) call get_command_argument(i, arguments(i)%text)
      end do
   end subroutine get_arguments

   !> Parses the arguments. The first error is reported in `command%error`.
   subroutine parse_arguments(arguments, command)
      type(argument_t), intent(in) :: arguments(:)
      type(command_t), intent(out) :: command
      logical :: given(size(options)), is_word(size(arguments))
      integer :: i, width

      ! The mark of `--unset` needs one more character.
      width = maxval([0, (len(arguments(i)%text), i=1, size(arguments))]) + 1
      allocate (character(len=width) :: command%overrides(0))
      given = .false.
      is_word = .false.
      i = 1
      do while (i <= size(arguments) .and. .not. allocated(command%error))
         if (arguments(i)%text == '--') then
            is_word(i + 1:) = .true.
            exit
         end if
         if (index(arguments(i)%text, '-') == 1 .and. len(arguments(i)%text) > 1) then
            call parse_option()
         else
            is_word(i) = .true.
         end if
         i = i + 1
      end do
      if (allocated(command%error)) return
      if (given(option_number('--version'))) then
         command%verb = 'version'
      else if (size(arguments) > 0) then
         call parse_words(pack(arguments, is_word))
      end if

   contains

      !> Parses an option, `--name=value` or `--name value`, and advances over a separate value.
      subroutine parse_option()
         character(len=:), allocatable :: name, value
         integer :: equals, n
         logical :: has_value

         equals = index(arguments(i)%text, '=')
         has_value = equals > 0
         name = arguments(i)%text
         value = ''
         if (has_value) value = name(equals + 1:)
         if (has_value) name = name(1:equals - 1)
         if (name == '-h') name = '--help'
         if (name == '-o') name = '--output'
         n = option_number(name, arguments(1)%text)
         if (n == 0) then
            command%error = 'unknown option '//quoted(name)//hint(nearest_name(name, options%name))
         else if (options(n)%value == '') then
            if (has_value) command%error = name//' takes no value'
         else if (.not. has_value) then
            if (i < size(arguments)) then
               i = i + 1
               value = arguments(i)%text
            else
               command%error = name//' needs a value ('//name//' '//trim(options(n)%value)//')'
            end if
         end if
         if (allocated(command%error)) return
         if (given(n) .and. options(n)%value /= '' .and. all(name /= ['--set  ', '--unset'])) &
            command%error = name//' is given twice'
         given(n) = .true.
         call set_value(name, value, options(n)%value /= '')
      end subroutine parse_option

      !> Stores the value of an option.
      subroutine set_value(name, value, has_value)
         character(len=*), intent(in) :: name, value
         !> True if the option has a value.
         logical, intent(in) :: has_value
         integer(long) :: count
         select case (name)
         case ('--output')
            command%output = value
            if (value == '') command%error = '--output needs the name of a file, or - for standard output'
         case ('--set')
            command%overrides = [character(len=len(command%overrides)) :: command%overrides, value]
            if (index(value, '-') == 1) &
               command%error = '--set '//quoted(value)//' is not a setting (expected GROUP.KEY=VALUE)'
         case ('--unset')
            command%overrides = [character(len=len(command%overrides)) :: command%overrides, '-'//value]
         case ('--csv')
            command%csv = value
            if (value == '') command%error = '--csv needs the name of a file, or - for standard output'
         case ('--plot', '--columns', '--title', '--residuals', '--xy', '--path', '--from')
            call set_drawing(name, value)
         case ('--scene', '--aem', '--aem-version', '--gltf', '--speed', '--error')
            call set_export(name, value)
         case ('--json', '--period', '--equilibria', '--relative-rates')
            call set_linear(name, value)
         case ('--seconds', '--evaluations', '--max-steps', '--max-rows')
            call set_budget(name, value)
         case ('--checkpoint')
            command%checkpoint = value
            if (value == '') command%error = '--checkpoint needs the name of a file'
         case ('--every-seconds')
            call set_number(name, value, 0.0_wp, 1e6_wp, 'not a time (expected 0 to 1e6 s)', command%every_seconds, &
                            command%error)
         case ('--resume')
            if (.not. has_value) then
               command%goes_on = .true.
            else
               command%resume = value
               if (value == '') command%error = '--resume needs the name of a file'
            end if
         case ('--members')
            call set_members(value)
         case ('--member')
            call set_count(name, value, 'the number of a member', command%member, command%error)
         case ('--threads')
            call set_count(name, value, 'a number of threads', count, command%error)
            command%threads = int(min(count, 4096_long))
         case ('--merge')
            command%merges = .true.
         case ('--all')
            command%draws_all = .true.
         case ('--quiet')
            command%quiet = .true.
         case default
            ! The other options have no value to store.
            continue
         end select
      end subroutine set_value

      !> Stores the budget of a work-precision study, or a limit of steps or rows.
      subroutine set_budget(name, value)
         !> Option and its value.
         character(len=*), intent(in) :: name, value
         select case (name)
         case ('--seconds')
            call set_number(name, value, 0.1_wp, 1e6_wp, 'not a time (expected 0.1 to 1e6 s)', command%seconds, &
                            command%error)
         case ('--evaluations')
            call set_count(name, value, 'a number of evaluations', command%evaluations, command%error)
         case ('--max-steps')
            call set_count(name, value, 'a number of steps', command%max_steps, command%error)
         case default
            call set_count(name, value, 'a number of rows', command%max_rows, command%error)
         end select
      end subroutine set_budget

      !> Stores an option of `nutate linearize`: the period, what is linearised, or the JSON file.
      subroutine set_linear(name, value)
         !> Option and its value.
         character(len=*), intent(in) :: name, value
         if (name == '--equilibria') then
            command%equilibria = .true.
         else if (name == '--relative-rates') then
            command%relative_rates = .true.
         else if (name == '--json') then
            command%json = value
            if (value == '') command%error = '--json needs the name of a file, or - for standard output'
         else if (value == 'orbit') then
            command%period = -1.0_wp
         else
            call set_number(name, value, 1e-9_wp, 1e15_wp, 'out of its range (expected 1e-9 to 1e15 s, or orbit)', &
                            command%period, command%error)
         end if
      end subroutine set_linear

      !> Stores an option of a picture or of an animation.
      subroutine set_drawing(name, value)
         !> Option and its value.
         character(len=*), intent(in) :: name, value
         !> Body axes by their number, and 4 added to it.
         character(len=2), parameter :: axes(7) = ['-3', '-2', '-1', '  ', '1 ', '2 ', '3 ']
         real(wp) :: time
         select case (name)
         case ('--plot')
            command%plot = value
            if (.not. is_picture(value)) command%error = '--plot '// &
               quoted(value)//' is not a picture file (expected the name '// &
                                                         'of a file in .svg, .png or .pdf)'
         case ('--columns')
            command%columns = value
            if (value == '') command%error = '--columns needs names of columns (--columns energy,omega3)'
         case ('--from')
            command%begin = value
            call set_number(name, value, -huge(1.0_wp), huge(1.0_wp), 'not a time (expected seconds)', time, &
               command%error)
         case ('--residuals')
            command%residuals = .true.
         case ('--xy')
            command%xy = value
            if (index(value, ':') <= 1 .or. index(value, ':') == len(value)) command%error = '--xy '//quoted(value)// &
               ' is not a pair of columns (expected NAME:NAME, such as omega1:omega2)'
         case ('--path')
            command%path = findloc(axes, value, dim=1) - 4
            if (all(axes /= value) .or. value == '') command%error = '--path '//quoted(value)// &
               ' is not a body axis (expected 1, 2, 3, or -1, -2, -3)'
         case default
            command%title = value
         end select
      end subroutine set_drawing

      !> Stores an option of `nutate export`: a file, the scene, or a setting of a format.
      subroutine set_export(name, value)
         !> Option and its value.
         character(len=*), intent(in) :: name, value
         select case (name)
         case ('--scene')
            command%of_scene = value
         case ('--aem')
            command%aem = value
         case ('--gltf')
            command%gltf = value
         case ('--aem-version')
            command%aem_version = value
            if (.not. is_listed(value, aem_versions)) command%error = name//' '//quoted(value)// &
               ' is not available (expected '//comma_list(split_list(aem_versions))//')'
         case ('--speed')
            call set_number(name, value, 1e-9_wp, 1e12_wp, 'out of its range (expected 1e-9 to 1e12)', command%speed, &
                            command%error)
         case default
            call set_number(name, value, 1e-12_wp, 1.0_wp, 'out of its range (expected 1e-12 to 1 rad)', &
                            command%error_between, command%error)
         end select
         if (value == '') command%error = name//' needs the name of a file'
      end subroutine set_export

      !> Stores the members of a sweep, `A:B`.
      subroutine set_members(value)
         character(len=*), intent(in) :: value
         character(len=:), allocatable :: error
         integer :: colon
         colon = index(value, ':')
         call set_count('', value(:max(colon - 1, 0)), '', command%first, error)
         call set_count('', value(colon + 1:), '', command%last, error)
         if (colon == 0 .or. allocated(error) .or. command%first > command%last) &
            command%error = '--members '//quoted(value)//' is not a range of members (expected A:B, such as 1:1000)'
      end subroutine set_members

      !> Parses the words that are not options: the command, which may be left out, and the scene.
      subroutine parse_words(words)
         type(argument_t), intent(in) :: words(:)
         character(len=:), allocatable :: object
         integer :: first, verb

         first = 1
         command%verb = 'run'
         if (size(words) > 0) then
            if (words(1)%text == 'help') then
               call parse_topic(words)
               return
            else if (any(verbs%name == words(1)%text)) then
               command%verb = words(1)%text
               command%topic = command%verb
               first = 2
            else if (.not. names_a_scene(words(1)%text)) then
               command%error = 'unknown command '//quoted(words(1)%text)//hint(nearest_name(words(1)%text, verbs%name))
               if (did_you_mean(words(1)%text, '.nml') /= '') command%error = 'unknown command '// &
                  quoted(words(1)%text)//' ('//did_you_mean(words(1)%text, '.nml')//')'
               return
            end if
         end if
         if (given(option_number('--help'))) then
            command%verb = 'help'
            return
         end if
         call check_options()
         if (allocated(command%error)) return
         verb = findloc(verbs%name == command%verb, .true., dim=1)
         object = trim(merge('scene  ', 'history', verbs(verb)%object == 'SCENE'))
         if (size(words) < first) then
            command%error = 'there is no '//object//' (expected nutate '//trim(command%verb)//' '// &
                            trim(verbs(verb)%object)//')'
         else if (size(words) > first) then
            command%error = 'unexpected argument '//quoted(words(first + 1)%text)//' (expected one '//object//')'
         else if (words(first)%text == '') then
            command%error = 'the name of the '//object//' is blank (expected nutate '//trim(command%verb)//' '// &
                            trim(verbs(verb)%object)//')'
         else if (command%verb == 'export' .and. .not. (allocated(command%aem) .or. allocated(command%gltf))) then
            command%error = 'nutate export has no file to write (expected --aem FILE or --gltf FILE)'
         else
            command%scene = words(first)%text
         end if
      end subroutine parse_words

      !> Parses the words of `nutate help` and `nutate help COMMAND`.
      subroutine parse_topic(words)
         type(argument_t), intent(in) :: words(:)
         command%verb = 'help'
         if (size(words) < 2) return
         if (size(words) > 2) then
            command%error = 'unexpected argument '//quoted(words(3)%text)//' (expected one command)'
         else if (any(verbs%name == words(2)%text)) then
            command%topic = words(2)%text
         else
            command%error = 'unknown command '//quoted(words(2)%text)//hint(nearest_name(words(2)%text, verbs%name))
         end if
      end subroutine parse_topic

      !> Checks that the given options belong to the command and can be combined.
      subroutine check_options()
         integer :: i
         do i = 1, size(options)
            if (.not. given(i)) cycle
            ! The meaning of an option depends on the command, which may follow it.
            if (.not. is_listed(command%verb, trim(options(option_number(options(i)%name, command%verb))%verbs))) then
               command%error = 'nutate '//trim(command%verb)//' has no option '//trim(options(i)%name)// &
                               ' (see nutate '//trim(command%verb)//' --help)'
               return
            end if
         end do
         if (given(option_number('--seconds')) .and. given(option_number('--evaluations'))) &
            command%error = '--seconds and --evaluations exclude each other (expected one of them)'
         if (count([allocated(command%columns), allocated(command%xy), command%path /= 0]) > 1) &
            command%error = '--columns, --xy and --path exclude each other (expected one of them)'
         if (command%verb == 'run' .and. .not. allocated(command%plot) .and. &
             (allocated(command%columns) .or. allocated(command%xy) .or. allocated(command%title) .or. &
              command%path /= 0 .or. command%residuals)) &
            command%error = '--columns, --residuals, --xy, --path and --title need --plot FILE'
         if (given(option_number('--every-seconds')) .and. .not. (allocated(command%checkpoint) .or. &
             allocated(command%resume))) command%error = '--every-seconds needs --checkpoint FILE'
         if (command%equilibria .and. abs(command%period) > 0.0_wp) &
            command%error = '--equilibria cannot be combined with --period'
         if (command%relative_rates .and. (command%equilibria .or. abs(command%period) > 0.0_wp)) &
            command%error = '--relative-rates cannot be combined with --period or --equilibria'
         if (command%member > 0 .and. (command%first > 0 .or. command%merges .or. command%goes_on)) &
            command%error = '--member cannot be combined with --members, --merge or --resume'
         if (command%merges .and. (command%first > 0 .or. command%goes_on)) &
            command%error = '--merge runs no members'
      end subroutine check_options

   end subroutine parse_arguments

   !> Returns the position of an option in the table; 0 if it is not there.
   pure integer function option_number(name, verb)
      character(len=*), intent(in) :: name
      !> Command that decides between options of the same name.
      character(len=*), intent(in), optional :: verb
      integer :: i
      option_number = 0
      if (len(name) <= len(options%name)) option_number = findloc(options%name, name, dim=1)
      if (option_number == 0 .or. .not. present(verb)) return
      do i = option_number, size(options)
         if (options(i)%name /= name .or. .not. is_listed(verb, trim(options(i)%verbs))) cycle
         option_number = i
         return
      end do
   end function option_number

   !> Stores a number between two limits.
   subroutine set_number(name, value, least, most, fault, number, error)
      !> Option and its value.
      character(len=*), intent(in) :: name, value
      real(wp), intent(in) :: least, most
      !> Fault of another value, with what is expected: `not a time (expected seconds)`.
      character(len=*), intent(in) :: fault
      real(wp), intent(inout) :: number
      character(len=:), allocatable, intent(inout) :: error
      character(len=:), allocatable :: problem
      call read_real(value, number, problem)
      if (problem == '' .and. number >= least .and. number <= most) return
      error = name//' '//quoted(value)//' is '//fault
   end subroutine set_number

   !> Stores a positive count.
   subroutine set_count(name, value, meaning, count, error)
      !> Option and its value.
      character(len=*), intent(in) :: name, value
      !> Meaning of the count, in words.
      character(len=*), intent(in) :: meaning
      integer(long), intent(inout) :: count
      character(len=:), allocatable, intent(inout) :: error
      integer :: iostat
      iostat = 1
      if (verify(value, '0123456789') == 0 .and. value /= '' .and. len(value) <= 18) &
         read (value, *, iostat=iostat) count
      if (iostat == 0 .and. count > 0) return
      count = 1
      error = name//' '//quoted(value)//' is not '//meaning//' (expected 1, 2, ...)'
   end subroutine set_count

   !> Returns true for a file that exists and for anything that is written like a path.
   logical function names_a_scene(word)
      character(len=*), intent(in) :: word
      names_a_scene = scan(word, './') > 0
      if (.not. names_a_scene .and. word /= '') inquire (file=word, exist=names_a_scene)
   end function names_a_scene

   !> Returns what to try instead of an unknown name.
   pure function hint(nearest) result(text)
      !> Nearest known name; blank if there is none.
      character(len=*), intent(in) :: nearest
      character(len=:), allocatable :: text
      text = ' (see nutate --help)'
      if (nearest /= '') text = ' (nearest: '//nearest//')'
   end function hint

end module nutate_cli
